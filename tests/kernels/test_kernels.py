"""The compiled code itself: packed instructions, a cache that is never stale, and the Runge-Kutta formulas."""

from __future__ import annotations

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
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from threading import Timer

import llvmlite.binding as llvm
import numba as nb
import numpy as np
import pytest
from from_python import called
from numba.extending import overload
from scipy.integrate._ivp import dop853_coefficients as dop853
from small_study import write

import tolmc.kernels
from tolmc.kernels import code, engine, jit, kept, notices, sums
from tolmc.kernels.bare import Counts, Rows, Table
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
    before = kept.source_hash(copy)
    assert before == kept.source_hash(SOURCES)
    assert kept.cache_directory().name == f"numba-{before}"
    seen = {before}
    files = sorted(copy.rglob("*.py"))
    assert {"jit.py", "parameters.py", "tableaux.py", "slope_axial.py"} <= {file.name for file in files}
    for file in files:
        source = file.read_text()
        file.write_text(source + "# changed\n")
        seen.add(kept.source_hash(copy))
        file.write_text(source)
        assert kept.source_hash(copy) == before
    for new in (copy / "new.py", copy / "formulations" / "new.py"):
        new.write_text("")
        seen.add(kept.source_hash(copy))
    assert len(seen) == len(files) + 3


def test_the_place_of_the_cache_can_be_chosen(monkeypatch, tmp_path):
    monkeypatch.setenv("TOLMC_CACHE_DIR", str(tmp_path))
    assert kept.cache_directory() == tmp_path / f"numba-{kept.source_hash()}"


def test_nothing_is_kept_beside_installed_sources(monkeypatch, tmp_path):
    """It would outlive an uninstall and hide a later editable install."""
    monkeypatch.delenv("TOLMC_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    installed = tmp_path / "lib" / "site-packages" / "tolmc" / "kernels"
    shutil.copytree(SOURCES, installed, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(kept, "_HERE", installed)
    assert kept.cache_directory().parent == tmp_path / "cache" / "tolmc"


def toy(folder):
    """A package with tolmc's own modules that keep what is compiled, and sources of its own."""
    package = folder / "toy"
    package.mkdir()
    (package / "__init__.py").touch()
    for name in ("jit", "code", "kept"):
        source = (SOURCES / f"{name}.py").read_text()
        others = "from tolmc.kernels import bare, notices\nfrom toy import"
        source = source.replace("from tolmc.kernels import bare, code, kept, notices", f"{others} code, kept")
        source = source.replace("from tolmc.kernels import kept", "from toy import kept")
        (package / f"{name}.py").write_text(source.replace("tolmc.kernels.code", "toy.code"))
    return package


@compiled_only
@pytest.mark.slow
def test_an_edit_of_a_helper_reaches_its_callers(tmp_path):
    """A package with a helper in one file and an entry point in another, compiled, kept, edited, run again."""
    package = toy(tmp_path)
    (package / "entry.py").write_text(
        "from __future__ import annotations\n"
        "import numpy as np\nfrom toy import jit\nfrom toy.helper import helper\n\n\n"
        "def template(x: Rows):\n    x[0] = helper(x[0])\n\n\n"
        "entry = jit.entry(template, 'entry')\n\n\n"
        "@jit.kernel\ndef kernel(x):\n    return helper(x)\n"
    )

    def result(factor):
        (package / "helper.py").write_text(
            f"from toy.jit import device\n\n\n@device\ndef helper(x):\n    return {factor} * x\n"
        )
        program = (
            "import numpy as np; from toy import code; is_there = code.is_kept('entry');"
            "from toy.entry import entry, kernel; x = np.ones(1); entry(x);"
            "print(x[0], is_there, kernel(1.0), sum(kernel.stats.cache_hits.values()))"
        )
        # -B: two edits within a second look alike to Python's own cache.
        command, environment = [sys.executable, "-B", "-c", program], {**os.environ, "TOLMC_CACHE_DIR": str(tmp_path)}
        run = subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True, text=True)
        return run.stdout.split()

    assert result(2.0) == ["2.0", "False", "2.0", "0"]
    assert result(2.0) == ["2.0", "True", "2.0", "1"]
    assert result(3.0) == ["3.0", "False", "3.0", "0"]


_TOGETHER = """
import sys, time
from pathlib import Path
from threading import Timer
import numpy as np
from numba.core import event
from toy import jit

@jit.routine
def swap(x, n):
    for i in range(n):
        x[i] = x[n - i] + 1.0

def template(x: "Rows"):
    swap(x, 1)

called = jit.kernel(template) if sys.argv[2] == "kernel" else jit.entry(template, "entry")
Path(sys.argv[1]).touch()
while not all(Path(name).exists() for name in "ab"):
    time.sleep(0.001)
with event.install_recorder("numba:compile") as compiled:
    called(np.ones(8))
print(len(compiled.buffer) > 0)
"""


@compiled_only
@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX locks files")
@pytest.mark.parametrize("kind", ["entry", "kernel"])
def test_of_two_processes_that_need_a_kernel_at_once_one_compiles_it(tmp_path, kind):
    toy(tmp_path)
    (tmp_path / "program.py").write_text(_TOGETHER)
    environment = {**os.environ, "TOLMC_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(SOURCES.parents[1])}
    processes = [
        subprocess.Popen(
            [sys.executable, "program.py", name, kind], cwd=tmp_path, env=environment, stdout=subprocess.PIPE
        )
        for name in "ab"
    ]
    assert sorted(process.communicate()[0] for process in processes) == [b"False\n", b"True\n"]


@jit.routine
def _double(rows, count):
    for m in range(count):
        rows[m] *= 2.0


def _doubled(rows: Rows, table: Table, whole: Counts, count: int, factor: float, is_set: bool, space: Rows):
    """An entry with an argument of each kind."""
    _double(rows, count)
    for m in range(whole[0] if is_set else 0):
        space[m] = factor * table[1, m]
        table[1, m] = space[m] + table.shape[0]
    whole[0] += 1


def doubled(entry):
    rows, table, whole = np.arange(6.0), np.arange(6.0).reshape(2, 3), np.array([2])
    entry(rows, table, whole, 3, 10, True)
    np.testing.assert_array_equal(rows, [0.0, 2.0, 4.0, 3.0, 4.0, 5.0])
    np.testing.assert_array_equal(table, [[0.0, 1.0, 2.0], [32.0, 42.0, 5.0]])
    assert whole == [3]


def test_an_entry_takes_numbers_and_arrays(monkeypatch, tmp_path):
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))


@compiled_only
def test_an_entry_found_on_disk_is_the_one_that_was_compiled(monkeypatch, tmp_path):
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    assert not code.is_kept("doubled") and code.kept_entry("doubled") is None
    made = jit.entry(_doubled, "doubled", buffers=[6], sizes={"rows": 6})
    doubled(made)
    found = code.kept_entry("doubled")
    assert code.is_kept("doubled") and found.head.sizes == {"rows": 6}
    doubled(found)
    monkeypatch.setattr(jit.LazyEntry, "_compiled", None)
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))
    assert not list(tmp_path.glob("*.new"))


@compiled_only
@pytest.mark.parametrize("damage", ["cut", "changed", "emptied", "head changed", "of another form"])
def test_a_file_that_is_not_what_was_written_is_compiled_anew(monkeypatch, tmp_path, damage):
    """Its code would be run as it is."""
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))
    (file,) = tmp_path.glob("*.code")
    whole = file.read_bytes()
    digest, head, machine_code = whole.split(b"\n", 2)
    other = head.replace(b"symbol", b"name") + b"\n" + machine_code
    file.write_bytes({
        "cut": whole[:-100], "changed": whole[:-100] + bytes(100), "emptied": b"",
        "head changed": digest + b"\n" + head.replace(b"[6]", b"[1]") + b"\n" + machine_code,
        "of another form": code._digest(other) + b"\n" + other,
    }[damage])  # fmt: skip
    assert code.read("doubled") is None
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))
    assert code.read("doubled") is not None


@compiled_only
def test_an_entry_whose_libraries_are_not_there_is_left_to_numba(monkeypatch, tmp_path):
    """Which may bring them: it has vectors of sines where Intel's library is installed."""
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    entry = jit.entry(_doubled, "doubled", buffers=[6])
    doubled(entry)
    head, machine_code = code.read("doubled")
    code.keep("doubled", replace(head, needs=["sin", "no_such_function"]), machine_code)
    assert code.kept_entry("doubled") is None
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))  # which compiles it anew
    assert code.read("doubled")[0].needs == []
    code.keep("doubled", replace(head, needs=["sin"]), machine_code)
    doubled(code.kept_entry("doubled"))


@compiled_only
@pytest.mark.parametrize(
    "wrong", [np.arange(6), np.arange(12.0)[::2], np.zeros((2, 3)), np.arange(6.0, dtype=np.float32)]
)
def test_an_entry_refuses_an_array_of_another_kind(monkeypatch, wrong):
    """It would be read as what it is not."""
    monkeypatch.setattr(kept, "CACHE", None)
    entry = jit.entry(_doubled, "doubled", buffers=[6])
    with pytest.raises(TypeError, match="an entry takes a contiguous array of 1 dimension"):
        entry(wrong, np.zeros((2, 3)), np.array([2]), 3, 10.0, True)


@compiled_only
def test_what_others_write_wrongly_is_said_as_ever(monkeypatch):
    """Numba's own table of functions is not the one that remembers."""
    monkeypatch.setattr(kept, "CACHE", None)
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))

    @nb.njit
    def wrong(numbers):
        return numbers * "text"

    with pytest.raises(nb.TypingError):
        wrong(np.arange(6))


def test_a_disk_that_takes_nothing_costs_a_compilation_alone(monkeypatch, tmp_path):
    monkeypatch.setattr(kept, "CACHE", tmp_path / "gone")
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))


@compiled_only
def test_what_could_not_be_written_whole_is_taken_away(monkeypatch, tmp_path):
    def refuse(*_):
        raise OSError

    monkeypatch.setattr(kept, "CACHE", tmp_path)
    monkeypatch.setattr(code.os, "replace", refuse)
    doubled(jit.entry(_doubled, "doubled", buffers=[6]))
    assert [file.suffix for file in tmp_path.iterdir()] == [".lock"]


@compiled_only
@pytest.mark.skipif(sys.platform == "win32", reason="has no such modes")
def test_what_is_kept_can_be_read_by_whom_the_users_other_files_can(monkeypatch, tmp_path):
    """A place of the cache may be many users'."""
    monkeypatch.setattr(kept, "CACHE", tmp_path)
    before = os.umask(0o022)
    try:
        doubled(jit.entry(_doubled, "doubled", buffers=[6]))
    finally:
        os.umask(before)
    (file,) = tmp_path.glob("*.code")
    assert file.stat().st_mode & 0o777 == 0o644


def test_an_argument_of_no_kind_is_said():
    def template(x: Fraction):
        """One of an entry that nobody can call."""

    with pytest.raises(
        TypeError, match=r"wrong: its template's arguments are annotated \['Fraction'\]; allowed, as text: int"
    ):
        jit.entry(template, "wrong")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX locks files")
def test_waiting_for_another_process_is_told(monkeypatch, tmp_path):
    """For whoever watches it is a compilation like any other."""
    import fcntl

    monkeypatch.setattr(kept, "CACHE", tmp_path)
    told = []
    with (tmp_path / "kernel.lock").open("ab") as held, notices.listening(told.append, lambda: told.append("ended")):
        fcntl.flock(held, fcntl.LOCK_EX)
        release = Timer(0.2, lambda: fcntl.flock(held, fcntl.LOCK_UN))
        release.start()
        with kept.no_other_process("kernel", lambda: notices.compiling("tolmc.kernels")):
            assert told == ["tolmc.kernels", "ended"]
        release.join()
        with kept.no_other_process("kernel", lambda: notices.compiling("tolmc.kernels")):
            assert told == ["tolmc.kernels", "ended"]


@compiled_only
def test_functions_of_no_module_are_compiled_as_ever():
    made = {}
    exec("def square(x):\n    return x * x", {}, made)
    assert made["square"].__module__ is None
    assert nb.njit(made["square"])(3.0) == 9.0


_FROM_DISK = """
import sys
import tolmc
study = tolmc.load_study(sys.argv[1])
tolmc.simulate_many(study.scene, bearing_radius=[0.02], journal_radius=[0.01], half_length=[0.02])
tolmc.simulate(study.scene)
print("numba" in sys.modules)
"""


@compiled_only
def test_where_its_kernels_are_on_disk_a_run_does_without_numba(tmp_path):
    """Which takes half a second to load, as long as a small run computes."""
    command = [sys.executable, "-c", _FROM_DISK, str(write(tmp_path))]
    _, second = (subprocess.run(command, check=True, capture_output=True, text=True).stdout for _ in "ab")
    assert second == "False\n"


@compiled_only
def test_a_kernel_shows_its_entry_alone(monkeypatch, tmp_path):
    """Two kernels that were loaded would otherwise share the pieces of the one that was loaded first."""
    monkeypatch.setattr(kept, "CACHE", tmp_path)

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
    monkeypatch.setattr(kept, "CACHE", tmp_path)

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
    monkeypatch.setattr(kept, "CACHE", tmp_path)

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
    monkeypatch.setattr(kept, "CACHE", tmp_path)
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
    monkeypatch.setattr(kept, "CACHE", None)  # before it looks on disk Numba learns all by itself
    assert jit.kernel(lambda x: x + x)(np.float32(2.0)) == 4.0

    @overload(operator.add)
    def add_texts(a, b):
        """Nothing that a kernel has: of these types Numba is to ask others."""

    assert jit.kernel(lambda x: x + 2 * x)(np.float32(2.0)) == 6.0


_NUMBERS = """
import hashlib, sys
import tolmc
from tolmc.tolerances.draw import sample
study = tolmc.load_study(sys.argv[1])
samples = sample(study.tolerances, 3000, sampling="sobol", seed=7)
found = tolmc.simulate_many(study.scene, **samples, step=study.scene.duration / 6).drop(columns="status")
print(hashlib.sha256(found.to_numpy().tobytes()).hexdigest())
print("numba" in sys.modules)
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
    assert (compiled[1], found[1]) == ("True", "False")
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
    monkeypatch.setattr(kept, "CACHE", tmp_path)
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
    assert str(kept.cache_directory()) != nb.config.CACHE_DIR


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
        at = called(sums.weighted_sum(terms))
        assert at(y, k.ravel(), size, m) == pytest.approx(y[m] + row @ k[:, m], rel=1e-13, abs=1e-13)
