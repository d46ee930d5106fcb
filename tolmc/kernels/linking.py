"""One piece of machine code a kernel: what a kernel calls is linked into it, and is no code of its own.

Numba makes machine code of every function that it compiles, and once more of its copy in every function that calls it; of the
copies that runs which was loaded first. Their products and sums are contracted in different ways, so that a sample's last
digits would depend on whether a process has compiled a kernel or has found it on disk. Here a function that compiled code
alone calls is kept as intermediate code, optimised in the kernel alone (a third less time to compile); and in a kernel all
but the entry is internal, so that it runs on its own pieces wherever it is loaded.
"""

from __future__ import annotations

from typing import Any, ClassVar

from llvmlite.binding import Linkage, ModuleRef, parse_assembly
from numba._dynfunc import make_function
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags


class _Settled(Flags):
    """A compiler's options that stay as they are, one object for each choice of them.

    Numba finds what it has compiled by its options, and compares them one by one, five million of them in a kernel: a tenth of
    its compilation.
    """

    __slots__ = ()
    _HASH = hash(Flags())  # of their names alone

    def copy(self) -> Flags:
        return Flags(self)  # to be changed by whoever asks for it

    def __hash__(self) -> int:
        return self._HASH

    def __eq__(self, other: object) -> bool:
        return self is other if isinstance(other, _Settled) else super().__eq__(other)


class _Options(Flags):
    """Options whose copy, which Numba looks at while it compiles, is the one that stays as it is."""

    __slots__ = ()
    _known: ClassVar[list[_Settled]] = []

    def copy(self) -> _Settled:
        for known in self._known:
            if known.values() == self.values():
                return known
        self._known.append(_Settled(self))
        return self._known[-1]


class _Piece(JITCodeLibrary):
    """Intermediate code, to be linked into that of its callers."""

    is_inlined = False

    def finalize(self) -> None:
        """Alone: what it calls joins it in the kernel, once, and not with each of its callers."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
        if not self.is_inlined:
            # Taken over by the loops of a whole kernel they make a motion with its statistics take half as long again.
            for function in self._final_module.functions:
                if function.linkage == Linkage.external and not function.is_declaration:
                    function.add_function_attribute("noinline")
        self._finalized = True
        self._with_callees: ModuleRef | None = None

    def alone(self) -> ModuleRef:
        """Its own code, without what it calls."""
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> ModuleRef:
        """Its code with all that it calls, for a function that is no kernel."""
        self._ensure_finalized()
        if self._with_callees is None:
            whole = self.alone().clone()
            _link(whole, self._linking_libraries)
            self._with_callees = whole
        return self._with_callees


def _link(module: ModuleRef, libraries: list[JITCodeLibrary]) -> None:
    """All that is called from here, once each."""
    found: dict[JITCodeLibrary, None] = {}
    _find(libraries, found)
    # Callers first: LLVM leaves out what nothing that it has linked refers to.
    for library in reversed(found):
        module.link_in(
            library.alone() if isinstance(library, _Piece) else library._get_module_for_linking(), preserve=True
        )


def _find(libraries: list[JITCodeLibrary], found: dict[JITCodeLibrary, None]) -> None:
    """Adds these and all that they call, and that is not linked into them already; each after what it calls."""
    for library in libraries:
        if library not in found:
            if isinstance(library, _Piece):
                _find(library._linking_libraries, found)
            found[library] = None


# Nobody runs it, nor may.
_NAME_ALONE = 'define void @"{}"() {{ unreachable }}'


class _Kernel(JITCodeLibrary):
    """A kernel, whose pieces nothing outside it can see."""

    def finalize(self) -> None:
        _link(self._final_module, self._linking_libraries)
        self._linking_libraries.clear()
        super().finalize()

    def _finalize_final_module(self) -> None:
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = Linkage.internal
        super()._finalize_final_module()


class _Entry(_Kernel):
    """A kernel that Python alone calls."""

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes]]:
        """Machine code, and beside it names alone where Numba keeps intermediate code for callers.

        Reading that took 0.03 s a kernel.
        """
        self._ensure_finalized()
        seen = (function for function in self._final_module.functions if function.linkage == Linkage.external)
        names = "\n".join(_NAME_ALONE.format(function.name) for function in seen if not function.is_declaration)
        return self.name, "object", (self._get_compiled_object(), parse_assembly(names).as_bitcode())


def _by_compiled_code_alone(library: JITCodeLibrary, fndesc: Any, env: Any) -> object:
    """What Numba knows a piece by: a function without an address."""
    return make_function(fndesc.lookup_module(), fndesc.qualname, "a piece of a kernel", 0, env, (library,))


class _Compiler(Compiler):
    def __init__(self, *context: Any) -> None:
        super().__init__(*context)
        self.state.flags = _Options(self.state.flags)


class PieceCompiler(_Compiler):
    """Compiler of functions that compiled code alone calls; called from Python they end the process."""

    def define_pipelines(self) -> list:
        state = self.state
        state.targetctx = state.targetctx.subtarget(get_executable=_by_compiled_code_alone)
        state.library = _Piece(state.targetctx.codegen(), "piece")
        state.library.is_inlined = state.flags.forceinline
        return super().define_pipelines()


class KernelCompiler(_Compiler):
    """Compiler of kernels."""

    _library: ClassVar[type[_Kernel]] = _Kernel

    def define_pipelines(self) -> list:
        self.state.library = self._library(self.state.targetctx.codegen(), "kernel")
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class EntryCompiler(KernelCompiler):
    """Compiler of kernels that Python alone calls: found on disk and called from other code they end the process."""

    _library = _Entry
