"""The compiled code itself: packed instructions, a cache that is never stale, and the Runge-Kutta formulas."""

import math
import operator
import os
import platform
import re
import shutil
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import llvmlite.binding as llvm
import numba as nb
import numpy as np
import pytest
from from_python import called
from numba.extending import overload
from scipy.integrate._ivp import dop853_coefficients as dop853
from small_study import write

import tolmc.kernels
from tolmc.kernels import engine, jit, tableaux
from tolmc.kernels.formulations import FORMULATIONS
from tolmc.kernels.tableaux import CLASSICAL, DORMAND_PRINCE, RK8, TABLEAUX

SOURCES = Path(tolmc.kernels.__file__).parent
compiled_only = pytest.mark.skipif(bool(nb.config.DISABLE_JIT), reason="looks at compiled code")
every_tableau = pytest.mark.parametrize("tableau", [*TABLEAUX.values(), RK8], ids=["rk4", "Dormand and Prince", "rk8"])


# Packed instructions


def step_instructions(formulation, method, load, forces):
    """How often each kind of arithmetic instruction stands in the machine code of a step, packed and scalar.

    The step is compiled afresh: Numba shows no code that comes from its cache.
    """
    stepper, _ = engine.stepper_of(formulation, method, load, forces)
    compiled = nb.njit(**jit._OPTIONS)(stepper.step.py_func)
    compiled.compile((nb.float64[::1],) * 6)
    (code,) = compiled.inspect_asm().values()
    counts = Counter()
    for name, form, register in re.findall(
        r"^\s+v(fn?m\w+?|div|r?sqrt|mul)(?:14)?([ps][ds])\s.*?%([xyz]mm)", code, re.MULTILINE
    ):
        packed = form == "ps" or (form == "pd" and register != "xmm")  # inverse roots begin in single precision
        counts["multiply-add" if name.startswith("f") else name.removeprefix("r"), packed] += 1
    return counts


@compiled_only
@pytest.mark.slow
@pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64") or not llvm.get_host_cpu_features().get("avx2"),
    reason="counts the vector instructions of x86-64 with AVX2 or more",
)
@pytest.mark.parametrize(
    ("formulation", "method", "load", "forces"),
    [
        ("slope_symmetric", "rk8", True, False),
        ("slope_symmetric", "rk8", False, False),
        ("slope_axial", "rk8", True, False),
        ("exact_symmetric", "rk8", True, False),
        ("slope_general", "rk8", True, False),
        *((name, "rk8", True, True) for name in FORMULATIONS),
        ("slope_symmetric", "rk4", True, True),
    ],
)  # fmt: skip
def test_the_loops_over_lanes_are_packed(formulation, method, load, forces):
    """Every packed loop keeps one scalar copy, for arrays that overlap; where there is only that one, lanes are not packed."""
    counts = step_instructions(formulation, method, load, forces)
    for name, share in (("div", 1.0), ("sqrt", 1.0), ("mul", 0.7), ("multiply-add", 0.9)):
        assert counts[name, True] > 0, name
        assert counts[name, True] >= share * counts[name, False], (name, counts)


# The cache


def test_the_cache_moves_when_any_kernel_source_changes(tmp_path):
    copy = tmp_path / "kernels"
    shutil.copytree(SOURCES, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = jit.source_hash(copy)
    assert before == jit.source_hash(SOURCES)
    assert jit.cache_directory().name == f"numba-{before}"
    seen = {before}
    files = sorted(copy.rglob("*.py"))
    assert {"jit.py", "parameters.py", "tableaux.py", "slope_axial.py"} <= {file.name for file in files}
    for file in files:
        source = file.read_text()
        file.write_text(source + "# changed\n")
        seen.add(jit.source_hash(copy))
        file.write_text(source)
        assert jit.source_hash(copy) == before
    for new in (copy / "new.py", copy / "formulations" / "new.py"):
        new.write_text("")
        seen.add(jit.source_hash(copy))
    assert len(seen) == len(files) + 3


def test_the_place_of_the_cache_can_be_chosen(monkeypatch, tmp_path):
    monkeypatch.setenv("TOLMC_CACHE_DIR", str(tmp_path))
    assert jit.cache_directory() == tmp_path / f"numba-{jit.source_hash()}"


def test_nothing_is_kept_beside_installed_sources(monkeypatch, tmp_path):
    """It would outlive an uninstall and hide a later editable install."""
    monkeypatch.delenv("TOLMC_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    installed = tmp_path / "lib" / "site-packages" / "tolmc" / "kernels"
    shutil.copytree(SOURCES, installed, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "_HERE", installed)
    assert jit.cache_directory().parent == tmp_path / "cache" / "tolmc"


@compiled_only
@pytest.mark.slow
def test_an_edit_of_a_helper_reaches_its_callers(tmp_path):
    """A package with a helper in one file and an entry point in another, compiled, cached, edited, run again."""
    package = tmp_path / "toy"
    package.mkdir()
    shutil.copy(SOURCES / "jit.py", package / "jit.py")
    (package / "__init__.py").touch()
    (package / "entry.py").write_text(
        "from toy.helper import helper\nfrom toy.jit import kernel\n\n\n@kernel\ndef entry(x):\n    return helper(x)\n"
    )

    def result(factor):
        (package / "helper.py").write_text(
            f"from toy.jit import device\n\n\n@device\ndef helper(x):\n    return {factor} * x\n"
        )
        program = "from toy.entry import entry; print(entry(1.0), sum(entry.stats.cache_hits.values()))"
        # -B: two edits within a second look alike to Python's own cache.
        command = [sys.executable, "-B", "-c", program]
        return subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout.split()

    assert result(2.0) == ["2.0", "0"]
    assert result(2.0) == ["2.0", "1"]
    assert result(3.0) == ["3.0", "0"]


_TOGETHER = """
import sys, time
from pathlib import Path
import numpy as np
from toy.jit import kernel

@kernel
def norms(x):
    total = x
    for i in range(10):
        total += np.linalg.norm(np.full((3, 3), total * i)) + np.sort(np.full(4, total)).sum()
    return total

Path(sys.argv[1]).touch()
while not all(Path(name).exists() for name in "ab"):
    time.sleep(0.001)
norms(1.0)
print(sum(norms.stats.cache_hits.values()))
"""


@compiled_only
@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX locks files")
def test_of_two_processes_that_need_a_kernel_at_once_one_compiles_it(tmp_path):
    (tmp_path / "toy").mkdir()
    shutil.copy(SOURCES / "jit.py", tmp_path / "toy" / "jit.py")
    (tmp_path / "program.py").write_text(_TOGETHER)
    environment = {**os.environ, "TOLMC_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(SOURCES.parents[1])}
    processes = [
        subprocess.Popen([sys.executable, "program.py", name], cwd=tmp_path, env=environment, stdout=subprocess.PIPE)
        for name in "ab"
    ]
    assert sorted(process.communicate()[0] for process in processes) == [b"0\n", b"1\n"]


@compiled_only
def test_a_kernel_shows_its_entry_alone(monkeypatch, tmp_path):
    """Two kernels that were loaded would otherwise share the pieces of the one that was loaded first."""
    monkeypatch.setattr(jit, "_CACHE", tmp_path)

    @jit.device
    def square(x):
        return x * x

    @jit.routine
    def add_squares(x, y):
        for m in range(len(x)):
            y[m] += square(x[m])

    def entry(x, y):
        add_squares(x, y)
        add_squares(y, y)

    compiled = jit.kernel(entry)
    x, y = np.array([1.0, 2.0]), np.array([1.0, 1.0])
    compiled(x, y)
    assert y.tolist() == [6.0, 30.0]
    (code,) = compiled.inspect_asm().values()
    assert re.search(r"^\S*_ZN\S*add_squares\S*:", code, re.MULTILINE)
    shown = re.findall(r"^\s+\.(?:globl|weak)\s+(\S+)", code, re.MULTILINE)
    assert shown
    assert not [name for name in shown if "entry" not in name]


@compiled_only
def test_a_function_has_pieces_of_its_own_beside_a_kernel(monkeypatch, tmp_path):
    """In a kernel a piece is handed less than all words of an array; others must not meet it there."""
    monkeypatch.setattr(jit, "_CACHE", tmp_path)

    @jit.routine
    def double(x, y):
        for m in range(len(x)):
            y[m] = 2.0 * x[m]

    def entry(x, y):
        double(x, y)
        double(y, x)

    @nb.njit
    def plain(x, y):
        double(x, y)
        double(y, x)

    for function in (jit.kernel(entry), plain):
        x, y = np.arange(40.0), np.empty(40)
        function(x, y)
        np.testing.assert_array_equal(x, 4.0 * np.arange(40))


@compiled_only
@pytest.mark.skipif(not llvm.get_host_cpu_features().get("avx512f"), reason="looks for vectors of eight numbers")
def test_loops_are_as_wide_as_the_processor(monkeypatch, tmp_path):
    """LLVM itself takes vectors of four on Intel's processors: a motion with its statistics took a quarter longer."""
    monkeypatch.setattr(jit, "_CACHE", tmp_path)

    @jit.routine
    def add_squares(x, y):
        for m in range(len(x)):
            y[m] += x[m] * x[m]

    def entry(x, y):
        add_squares(x, y)

    compiled = jit.kernel(entry)
    compiled(np.ones(32), np.ones(32))
    (code,) = compiled.inspect_asm().values()
    assert re.search(r"vfmadd\w+pd\s.*%zmm", code)


@compiled_only
def test_what_numba_makes_of_given_types_it_is_asked_once(monkeypatch, tmp_path):
    """A kernel has thousands of products and of elements of arrays; with a question for each it takes half as long again."""
    monkeypatch.setattr(jit, "_CACHE", tmp_path)
    asked = Counter()
    answer = nb.types.Function.get_call_type

    def count(function, context, args, kws):
        asked[function.typing_key, args] += 1
        return answer(function, context, args, kws)

    # Of types that no kernel has: what has been asked before is known already.
    monkeypatch.setattr(nb.types.BaseFunction, "get_call_type", count)
    compiled = jit.kernel(lambda x, n: n * n * n + n * n * x[n] * x[n] + x[n + n])
    assert compiled(np.array([1, 2, 3, 4], dtype=np.int8), np.int16(1)) == 1 + 4 + 3
    of_kernel = {key: count for key, count in asked.items() if key[0] in (operator.mul, operator.add, operator.getitem)}
    assert len(of_kernel) > 3
    assert set(of_kernel.values()) == {1}


@compiled_only
def test_kernels_are_compiled_when_an_operator_has_learned_something(monkeypatch):
    monkeypatch.setattr(jit, "_CACHE", None)  # before it looks on disk Numba learns all by itself
    assert jit.kernel(lambda x: x + x)(np.float32(2.0)) == 4.0

    @overload(operator.add)
    def add_texts(a, b):
        """Nothing that a kernel has: of these types Numba is to ask others."""

    assert jit.kernel(lambda x: x + 2 * x)(np.float32(2.0)) == 6.0


_NUMBERS = """
import hashlib, sys
import tolmc
from tolmc.kernels import engine
from tolmc.tolerances.draw import sample
study = tolmc.load_study(sys.argv[1])
samples = sample(study.tolerances, 3000, sampling="sobol", seed=7)
found = tolmc.simulate_many(study.scene, **samples, step=study.scene.duration / 6).drop(columns="status")
print(hashlib.sha256(found.to_numpy().tobytes()).hexdigest())
kernel = engine.build("slope_symmetric", "rk8", load=True, forces=True)
print(sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""


@compiled_only
@pytest.mark.nightly  # it compiles a whole kernel; what would make the numbers differ the test above finds in a small one
def test_a_kernel_found_on_disk_gives_the_numbers_of_the_one_that_was_compiled(tmp_path):
    """To the last bit: a run that is resumed, or whose blocks other processes compute, is the run that it would have been."""
    study = write(tmp_path)
    environment = {**os.environ, "TOLMC_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", _NUMBERS, str(study)]
    compiled, found = (
        subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()
        for _ in "ab"
    )
    assert compiled[1:] == ["0", "1"]
    assert found[1:] == ["1", "0"]
    assert compiled[0] == found[0]


@compiled_only
def test_a_kernel_found_on_disk_is_called_by_one_that_is_compiled(tmp_path):
    """As a run by the published forms finds some of their kernels, when one that took fewer of them came before."""
    (tmp_path / "program.py").write_text(
        "import sys\nfrom tolmc.kernels import jit\n"
        "@jit.kernel\ndef inner(x):\n    return x * x\n"
        "@jit.kernel\ndef outer(x):\n    return inner(x) + 1.0\n"
        "print((inner if sys.argv[1] == 'first' else outer)(3.0))\n"
    )
    environment = {**os.environ, "TOLMC_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(SOURCES.parents[1])}
    said = {"cwd": tmp_path, "env": environment, "check": True, "capture_output": True, "text": True, "timeout": 60}
    first, second = (
        subprocess.run([sys.executable, "program.py", name], **said).stdout for name in ("first", "second")
    )
    assert (float(first), float(second)) == (9.0, 10.0)


@compiled_only
def test_kernels_made_in_several_threads_have_their_place_each(monkeypatch, tmp_path):
    """Threads that change Numba's setting side by side would leave each other the place that one of them has put back."""
    monkeypatch.setattr(jit, "_CACHE", tmp_path)
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            made = list(threads.map(lambda _: jit.kernel(lambda x: x), range(400)))
    finally:
        sys.setswitchinterval(usual)
    assert {str(Path(one._cache.cache_path).parent) for one in made} == {str(tmp_path)}
    assert str(tmp_path) != nb.config.CACHE_DIR


def test_numbas_own_setting_is_left_alone():
    assert str(jit.cache_directory()) != nb.config.CACHE_DIR


# Runge-Kutta formulas


@cache
def rooted_trees(order):
    """Rooted trees of ``order`` vertices, each as the sorted tuple of its root's branches."""
    if order == 1:
        return {()}
    grown = set()
    for tree in rooted_trees(order - 1):
        grown.add(tuple(sorted((*tree, ()))))
        for i, branch in enumerate(tree):
            for larger in rooted_trees(size(branch) + 1):
                grown.add(tuple(sorted((*tree[:i], larger, *tree[i + 1 :]))))
    return grown


def size(tree):
    return 1 + sum(map(size, tree))


def density(tree):
    return size(tree) * math.prod(map(density, tree))


def stage_weights(tree, matrix):
    """Phi_i(t): the product over the root's branches of (A Phi(branch))_i."""
    weights = np.ones(len(matrix))
    for branch in tree:
        weights = weights * (matrix @ stage_weights(branch, matrix))
    return weights


def test_number_of_rooted_trees():
    assert [len(rooted_trees(n)) for n in range(1, 10)] == [1, 1, 2, 4, 9, 20, 48, 115, 286]


@every_tableau
def test_order_conditions(tableau):
    """b . Phi(t) = 1/gamma(t) for every rooted tree t up to the order (Butcher), and not for all of the next."""
    for order in range(1, tableau.order + 2):
        left = [tableau.b @ stage_weights(t, tableau.matrix) - 1 / density(t) for t in rooted_trees(order)]
        assert (np.abs(left).max() < 5e-14) == (order <= tableau.order)


def test_coefficients_are_those_of_scipy():
    np.testing.assert_allclose(DORMAND_PRINCE.matrix, dop853.A[:12, :12], rtol=1e-15)
    np.testing.assert_allclose(DORMAND_PRINCE.b, dop853.B, rtol=1e-15)
    np.testing.assert_allclose(DORMAND_PRINCE.matrix.sum(axis=1), dop853.C[:12], atol=1e-14)


@every_tableau
def test_explicit(tableau):
    assert (np.triu(tableau.matrix) == 0).all()


@pytest.mark.parametrize("tableau", TABLEAUX.values(), ids=TABLEAUX)
def test_sampled_from_start_to_end(tableau):
    assert tableau.positions[0] == 0
    assert tableau.positions[-1] == 1
    assert (np.diff(tableau.positions) > 0).all()
    nodes = [*tableau.matrix.sum(axis=1), 0.5, 1.0]
    np.testing.assert_allclose(tableau.positions, [nodes[row] for row in tableau.samples], atol=1e-14)


def test_the_midpoint_is_of_third_order():
    """sum b_i c_i^k = 2^-(k+1)/(k + 1) for k < 3, and for b A c as well."""
    b = np.array([CLASSICAL.midpoint.get(i, 0.0) for i in range(CLASSICAL.stages)])
    c = CLASSICAL.matrix.sum(axis=1)
    for k in range(3):
        assert b @ c**k == pytest.approx(0.5 ** (k + 1) / (k + 1), abs=1e-15)
    assert b @ CLASSICAL.matrix @ c == pytest.approx(0.5**3 / 6, abs=1e-15)


def test_sums_are_rows_of_the_tableau():
    size, m = 12, 7
    rng = np.random.default_rng(1)
    y, k = rng.normal(size=size), rng.normal(size=(RK8.stages, size))
    for terms, row in zip([*RK8.rows, RK8.weights], [*RK8.matrix, RK8.b], strict=True):
        at = called(tableaux.weighted_sum(terms))
        assert at(y, k.ravel(), size, m) == pytest.approx(y[m] + row @ k[:, m], rel=1e-13, abs=1e-13)
