"""One-sided contact's kernels: equations, a stepper, events and lanes composed into the loop over rounds."""

from __future__ import annotations

from collections.abc import Callable

from tolmc.kernels import jit, names, results
from tolmc.kernels.lanes import WIDTH, Layout
from tolmc.kernels.once import once
from tolmc.kernels.one_sided import approach as approaches
from tolmc.kernels.one_sided import clock as clocks
from tolmc.kernels.one_sided import forecast, outcome
from tolmc.kernels.one_sided import jump as jumps
from tolmc.kernels.one_sided import lane as one_lane
from tolmc.kernels.one_sided import layout as at
from tolmc.kernels.one_sided import samples as ways
from tolmc.kernels.one_sided import stepper as steppers
from tolmc.kernels.one_sided.equations import equations_of
from tolmc.kernels.one_sided.rounds import all_rounds, rounds


@once
def build(*, exact: bool, general: bool, rubs: bool, swings: bool, rk4: bool) -> Callable:
    """Entry :func:`tolmc.kernels.one_sided.rounds.rounds` of one kind of scene.

    Parameters
    ----------
    exact, general : the exact section, any body
    rubs, swings : friction or a drive; loads or a drive that swing, which has friction too
    rk4 : rk4 in place of rk8
    """
    equations = equations_of(exact, general, rubs or swings, swings)
    stepper = steppers.build(equations, rk4)
    decide = one_lane.build(equations, stepper, rk4)
    approach = approaches.build(equations, stepper)
    at_event = jumps.build(equations)
    screen, take, renew = clocks.build(equations, stepper, rk4)
    way, store = ways.build(equations, at_event), outcome.build(equations)
    layout, n_state, stages = Layout(), equations.state, stepper.stages
    blocks = {
        "y_rows": n_state, "end_rows": n_state, "argument_rows": n_state, "f0_rows": n_state, "f1_rows": n_state,
        "k_rows": stepper.k_rows, "coef_rows": equations.coefficients, "lane_rows": at.CARRIED,
        "seen0_rows": at.SEEN, "seen1_rows": at.SEEN, "sample_rows": (stages + 1) * equations.samples,
        "result_rows": results.RESULTS,
        **dict(zip(("raw_rows", "given_rows", "start_rows", "ready_rows", "gap_rows"), way.rows, strict=True)),
    }  # fmt: skip
    places = {name: layout.block(count) for name, count in blocks.items()}
    name = names.one_sided(exact=exact, general=general, rubs=rubs, swings=swings, rk4=rk4)
    loop = jit.piece(
        all_rounds, f"{name}_loop",
        step=stepper.step, look=stepper.look, screen=screen, decide=decide, take=take, approach=approach,
        strike=at_event.strike, settle=at_event.settle, jump=at_event.jump, rubs=equations.rubs,
        renew=renew, forecast=forecast.build(equations).forecast,
        fetch=way.fetch, load=way.load, begin=way.begin, state_of=way.state_of, store=store, note=way.note,
        **places,
    )  # fmt: skip
    numbers = layout.rows * WIDTH
    return jit.entry(rounds, name, buffers=[WIDTH, WIDTH, numbers], loop=loop, everything=slice(0, numbers))
