"""What Numba does to make a kernel, less what it does there in vain: half of the time that a compilation takes.

That time passes in Python, in Numba's own analyses and types.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.cpu import CPUContext
from numba.core.ir_utils import build_definitions
from numba.core.rewrites.static_getitem import RewriteConstGetitems, RewriteConstSetitems
from numba.core.typed_passes import PreLowerStripPhis
from numba.core.typing.context import Context
from numba.core.untyped_passes import GenericRewrites
from numba.extending import models, register_model

from tolmc.kernels.linking import Alone, Kernel, Piece, by_compiled_code_alone

#: Passes for what no piece has: closures within, contexts, raised errors, loops over tuples of several types, expressions of
#: whole arrays, overloads to be inlined; and those that write for people. After each Numba analyses anew.
_IN_VAIN = {
    "WithLifting", "InlineClosureLikes", "MakeFunctionToJitFunction", "RewriteSemanticConstants", "RewriteDynamicRaises",
    "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass", "InlineOverloads", "NopythonRewrites",
    "NoPythonSupportedFeatureValidation", "DumpParforDiagnostics",
}  # fmt: skip
#: And those that find how long variables live, for references to be given up: a piece counts none.
_IN_VAIN_FOR_PIECES = _IN_VAIN | {"IRProcessing", "IRLegalization", "AnnotateTypes"}


@register_pass(mutates_CFG=True, analysis_only=False)
class _KnownPlaces(GenericRewrites):
    """Of what Numba rewrites before it seeks types, places that are known; no lives are sought after."""

    def run_pass(self, state: Any) -> bool:
        blocks = state.func_ir.blocks
        for rewrite in (RewriteConstGetitems(state), RewriteConstSetitems(state)):
            for label, block in blocks.items():
                if rewrite.match(state.func_ir, block, state.typemap, state.calltypes):
                    blocks[label] = rewrite.apply()
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _WithoutPhis(PreLowerStripPhis):
    """The same as Numba's, and no lives are sought after."""

    def run_pass(self, state: Any) -> bool:
        state.func_ir = self._strip_phi_nodes(state.func_ir)
        state.func_ir._definitions = build_definitions(state.func_ir.blocks)
        return True


_SHORTER = {GenericRewrites: _KnownPlaces, PreLowerStripPhis: _WithoutPhis}


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


class _Function(types.Function):
    """An operator or a function of Numba's, which remembers of what types it makes what.

    Of every product it is otherwise asked whether it is one of lists, of sets, of dates or of arrays, and that again whenever
    Numba looks whether all types are settled: twelve thousand questions in a kernel with three hundred answers.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function.templates)
        self._impl_keys = function._impl_keys  # others may have asked the function itself
        self._made: dict[tuple, Any] = {}

    def get_call_type(self, context: Any, args: tuple, kws: Mapping[str, types.Type]) -> Any:
        if kws:
            return super().get_call_type(context, args, kws)
        if args not in self._made:
            self._made[args] = super().get_call_type(context, args, kws)
        return self._made[args]


register_model(_Function)(models.OpaqueModel)


class _Typing(Context):
    """Numba's typing context, with all that it knows, and functions that remember."""

    _remembering: ClassVar[dict[types.Function, _Function]] = {}

    def __init__(self, context: Context) -> None:
        self.__dict__ = context.__dict__

    def refresh(self) -> None:
        plain = Context.__new__(Context)  # it adds to functions as they were
        plain.__dict__ = self.__dict__
        plain.refresh()

    def _lookup_global(self, value: Any) -> Any:
        found = super()._lookup_global(value)
        if type(found) is not types.Function:
            return found
        if found not in self._remembering:
            self._remembering[found] = _Function(found)
        return self._remembering[found]


class _Target(CPUContext):
    """Numba's target, which does not look for what it lacks again and again.

    It finds no way to convert arrays, nor to take a part of one by a constant, and looks each time whether anybody has brought
    one since: once for every element of an array. How much memory a type takes it asks LLVM of every variable, by a module of
    its own.
    """

    _sizes: ClassVar[dict[Any, int]] = {}

    def __init__(self, target: CPUContext, typing: Context) -> None:
        self.__dict__.update(target.__dict__, typing_context=typing)

    def get_function(self, fn: Any, sig: Any, _firstcall: bool = True) -> Any:
        return super().get_function(fn, sig, _firstcall and not isinstance(fn, str))

    def get_abi_sizeof(self, ty: Any) -> int:
        if ty not in self._sizes:
            self._sizes[ty] = super().get_abi_sizeof(ty)
        return self._sizes[ty]


class _Compiler(Compiler):
    _in_vain: ClassVar[set[str]] = _IN_VAIN

    def __init__(self, typing: Context, target: CPUContext, *choices: Any) -> None:
        typing = _Typing(typing)
        super().__init__(typing, _Target(target, typing), *choices)
        self.state.flags = _Options(self.state.flags)

    def define_pipelines(self) -> list[PassManager]:
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [one for one in pipeline.passes if one[0].__name__ not in self._in_vain]
        return pipelines


class PieceCompiler(_Compiler):
    """Compiler of functions that compiled code alone calls; called from Python they end the process."""

    _in_vain = _IN_VAIN_FOR_PIECES

    def _library(self) -> JITCodeLibrary:
        piece = Piece(self.state.targetctx.codegen(), "piece")
        piece.is_inlined = self.state.flags.forceinline
        return piece

    def define_pipelines(self) -> list[PassManager]:
        state = self.state
        state.targetctx = state.targetctx.subtarget(get_executable=by_compiled_code_alone)
        state.library = self._library()
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(_SHORTER.get(one, one), name) for one, name in pipeline.passes]
        return pipelines


class EntryCompiler(PieceCompiler):
    """Compiler of kernels that Python calls by their address."""

    def _library(self) -> JITCodeLibrary:
        return Alone(self.state.targetctx.codegen(), "entry")


class KernelCompiler(_Compiler):
    """Compiler of kernels for whoever calls them, which may have whole arrays in their expressions."""

    _in_vain: ClassVar[set[str]] = set()

    def define_pipelines(self) -> list[PassManager]:
        self.state.library = Kernel(self.state.targetctx.codegen(), "kernel")
        self.state.library.enable_object_caching()
        return super().define_pipelines()
