"""One piece of machine code a kernel: what a kernel calls is linked into it, and is no code of its own.

Numba makes machine code of every function that it compiles, and once more of its copy in every function that calls it; of the
copies that runs which was loaded first. Their products and sums are contracted in different ways, so that a sample's last
digits would depend on whether a process has compiled a kernel or has found it on disk. Here a function that compiled code
alone calls is kept as intermediate code, optimised in the kernel alone (a third less time to compile); and in a kernel all
but the entry is private, so that it runs on its own pieces wherever it is loaded.
"""

from __future__ import annotations

from typing import Any

from llvmlite.binding import Linkage, ModuleRef, create_new_module_pass_manager
from llvmlite.ir import DoubleType, Function, IntType, Module
from numba._dynfunc import make_function
from numba.core.codegen import JITCodeLibrary

#: Eight numbers at a time where a processor can: of Intel's LLVM takes four, with which a motion takes a quarter longer.
_WIDEST = '"prefer-vector-width"="512"'
_NUMBERS = DoubleType().as_pointer(), IntType(64).as_pointer()
_COUNTED = IntType(8).as_pointer()


class _Library(JITCodeLibrary):
    """Code whose loops over lanes are as wide as the processor."""

    def add_ir_module(self, ir_module: Module) -> None:
        for function in ir_module.functions:
            set.add(function.attributes, _WIDEST)  # llvmlite's own method takes attributes without a value alone
        super().add_ir_module(ir_module)

    def _optimize_functions(self, module: ModuleRef) -> None:
        """By one builder, that does not look for vectors yet: all is optimised once more in the kernel."""
        module.data_layout = self._codegen._data_layout
        builder = self._codegen._pass_builder(loop_vectorize=False, slp_vectorize=False)
        passes = builder.getFunctionPassManager()
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class Piece(_Library):
    """Intermediate code, to be linked into that of its callers."""

    is_inlined = False

    def add_ir_module(self, ir_module: Module) -> None:
        if not self.is_inlined:
            # Taken over by the loops of a whole kernel they make a motion with its statistics take half as long again.
            for function in ir_module.functions:
                if not function.is_declaration and not function.linkage:  # its own, which others see
                    function.attributes.add("noinline")
        for function in ir_module.functions:
            _tell_apart(function)
        super().add_ir_module(ir_module)

    def finalize(self) -> None:
        """Alone: what it calls joins it in the kernel, once, and not with each of its callers."""
        self._raise_if_finalized()
        self._finalize_dynamic_globals()
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


def _tell_apart(function: Function) -> None:
    """Rows that a piece is handed overlap nowhere where they are written: no loop need look whether they do.

    Of arrays, which come with the address of their count, that is not said.
    """
    types = {argument.type for argument in function.args}
    if not function.is_declaration and _COUNTED not in types:
        for argument in function.args:
            if argument.type in _NUMBERS:
                argument.add_attribute("noalias")


def _link(module: ModuleRef, libraries: list[JITCodeLibrary]) -> None:
    """All that is called from here, once each."""
    found: dict[JITCodeLibrary, None] = {}
    _find(libraries, found)
    # Callers first: LLVM leaves out what nothing that it has linked refers to.
    for library in reversed(found):
        module.link_in(
            library.alone() if isinstance(library, Piece) else library._get_module_for_linking(), preserve=True
        )


def _find(libraries: list[JITCodeLibrary], found: dict[JITCodeLibrary, None]) -> None:
    """Adds these and all that they call, and that is not linked into them already; each after what it calls."""
    for library in libraries:
        if library not in found:
            if isinstance(library, Piece):
                _find(library._linking_libraries, found)
            found[library] = None


class Kernel(_Library):
    """A kernel, whose pieces nothing outside it can see."""

    def finalize(self) -> None:
        _link(self._final_module, self._linking_libraries)
        self._linking_libraries.clear()
        super().finalize()

    def _optimize_final_module(self) -> None:
        """With private pieces: what none of them looks at, of the seven words of an array five, LLVM no longer hands over.

        Private and not internal, or the loader would take them for functions of the same name that others hand all words.
        """
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = Linkage.private
        super()._optimize_final_module()


class Alone(Kernel):
    """A kernel that Python alone calls, by its address: nothing of it is Numba's to load."""

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def machine_code(self) -> tuple[bytes, list[str]]:
        """It, and the functions of the system's libraries that it calls."""
        self._ensure_finalized()
        passes = create_new_module_pass_manager()
        passes.add_strip_dead_prototype_pass()
        passes.run(self._final_module, self._codegen._pass_builder())
        functions = self._final_module.functions
        needs = [one.name for one in functions if one.is_declaration and not one.name.startswith("llvm.")]
        return self._codegen._tm.emit_object(self._final_module), needs


def by_compiled_code_alone(library: JITCodeLibrary, fndesc: Any, env: Any) -> object:
    """What Numba knows a piece by: a function without an address."""
    return make_function(fndesc.lookup_module(), fndesc.qualname, "a piece of a kernel", 0, env, (library,))
