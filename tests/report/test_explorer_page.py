"""The explorer in a real browser: sliders, keyboard, what is announced, numbers, sizes of screens, no network."""

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
import small_study

from tolmc.allocation.explored import Explored, explore
from tolmc.analysis.surrogate import Surrogate
from tolmc.report.write import write_report
from tolmc.runs import directory as run_directory
from tolmc.runs import run as monte_carlo
from tolmc.study.study import Study

sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright, which drives the browser, is not installed")
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(BROWSER is None, reason="no browser: apt-get install chromium"),
]

PARTS = 10_000


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    study = small_study.write(folder, ("samples = 3000", f"samples = {PARTS}"))
    result = monte_carlo.run(study, out=folder / "run")
    (folder / "run" / "surrogate.json").write_text(explore(result.study, result.summary).json())
    write_report(folder / "run")
    return folder / "run"


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield found
        found.close()


@pytest.fixture
def open_page(browser, directory):
    """Opens the report; nothing may go wrong in it, nor may it ask for anything."""
    contexts, troubles = [], []

    def opened(**options):
        context = browser.new_context(**options)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on(
            "request",
            lambda request: troubles.append(request.url) if request.url[:5] not in ("file:", "data:") else None,
        )
        page.goto((directory / "report.html").as_uri())
        return page

    yield opened
    for context in contexts:
        context.close()
    assert troubles == []


def updated(page) -> None:
    """Wait until what was set is shown: a picture is drawn, and then another."""
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def expected(directory: Path, study: Study) -> tuple[dict[str, np.ndarray], float]:
    """Python's outputs of the run's parts in the zones of another study, and the share that keeps every limit."""
    run = run_directory.read(directory)
    samples = run.read(rows=PARTS).to_pandas()
    for d, own in zip(study.tolerances.dimensions, run.study().tolerances.dimensions, strict=True):
        share = (samples[d.name] - own.nominal) / (own.upper - own.lower)
        samples[d.name] = d.nominal + share * (d.upper - d.lower)
    surrogate = Explored.of_json((directory / "surrogate.json").read_text()).surrogate
    assert isinstance(surrogate, Surrogate)
    outputs = surrogate(samples)
    kept = np.logical_and.reduce([outputs[name] <= limits["max"] for name, limits in study.specification.items()])
    return {name: outputs[name].to_numpy() for name in outputs}, float(kept.mean())


def set_study(page) -> Study:
    """The study that the page would copy."""
    return Study.from_dict(tomllib.loads(page.locator("#explorer textarea").input_value()))


def test_a_slider_moved_by_keys_gives_pythons_numbers(open_page, directory):
    page = open_page()
    slider = page.get_by_role("slider", name="Bearing radius R*, Tolerance ±")
    slider.focus()
    for _ in range(7):
        page.keyboard.press("ArrowRight")
    updated(page)
    study = set_study(page)
    assert study.tolerances.dimensions[0].upper == pytest.approx(0.020057)
    outputs, kept = expected(directory, study)
    share = shown(page)
    assert float(share["value"]) == kept
    assert float(share["low"]) < kept < float(share["high"])
    figures = page.locator("#explorer .output")
    assert figures.count() == len(outputs)
    for k in range(figures.count()):
        found = figures.nth(k).evaluate("(e) => ({ ...e.dataset })")
        values = outputs[found["output"]]
        for name, value in (("mean", values.mean()), ("min", values.min()), ("max", values.max())):
            assert float(found[name]) == pytest.approx(value, rel=1e-12), (found["output"], name)
        assert float(found["sd"]) == pytest.approx(values.std(ddof=1), rel=1e-9)


def test_what_is_set_is_announced_and_taken_back(open_page):
    page = open_page()
    status = page.locator("#explorer [aria-live]")
    page.wait_for_function("document.querySelector('#explorer [aria-live]').textContent !== ''")
    before, text = status.text_content(), page.locator("#explorer textarea").input_value()
    page.get_by_role("spinbutton", name="Half length L, Tolerance ±, mm").fill("0.15")
    page.wait_for_function("(text) => document.querySelector('#explorer [aria-live]').textContent !== text", arg=before)
    assert "of the parts keep every limit" in status.text_content()
    assert page.locator("#explorer textarea").input_value() != text
    assert page.locator("#explorer.changed").count() == 1
    page.get_by_role("button", name="Back to the study").click()
    page.wait_for_function("(text) => document.querySelector('#explorer [aria-live]').textContent === text", arg=before)
    assert page.locator("#explorer textarea").input_value() == text
    assert page.locator("#explorer.changed").count() == 0


def shown(page) -> dict[str, str]:
    return page.locator("#explorer .share").evaluate("(e) => ({ ...e.dataset })")


def test_limits_are_moved_by_keys_hand_and_number(open_page, directory):
    page = open_page()
    figure = page.locator('#explorer [data-output="tilt_angle"]')
    field = page.get_by_role("spinbutton", name="Tilt angle ψ, largest allowed, deg")
    slider = page.get_by_role("slider", name="Tilt angle ψ, largest allowed")
    before = float(shown(page)["value"])

    def judged() -> float:
        """The limit that the study of what is set has; the share that keeps it is Python's."""
        updated(page)
        study = set_study(page)
        limit = study.specification["tilt_angle"]["max"]
        assert float(field.input_value()) == pytest.approx(np.degrees(limit), abs=1e-8)
        assert float(shown(page)["value"]) == expected(directory, study)[1]
        return limit

    own = judged()
    slider.focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    by_keys = judged()
    assert by_keys < own and float(shown(page)["value"]) < before

    figure.scroll_into_view_if_needed()
    box = figure.locator("svg").bounding_box()
    x = box["x"] + float(figure.locator("line.grip:not([hidden])").get_attribute("x1")) / 300 * box["width"]
    page.mouse.move(x, box["y"] + 30)
    page.mouse.down()
    page.mouse.move(x - 20, box["y"] + 30, steps=2)
    page.mouse.up()
    assert judged() < by_keys

    field.fill("60")
    judged()
    assert figure.locator(".aside.max").inner_text() == "≤ 60 →" and slider.is_hidden()
    page.get_by_role("spinbutton", name="Share of the parts that is asked for, %").fill("12.5")
    page.get_by_role("spinbutton", name="Tilt angle ψ, smallest allowed, deg").fill("20")
    field.fill("")
    updated(page)
    asked = set_study(page)
    assert asked.target == 0.125 and asked.specification["tilt_angle"] == {"min": pytest.approx(np.radians(20))}
    page.get_by_role("button", name="Back to the study").click()
    assert judged() == own and float(shown(page)["value"]) == before


def test_every_control_has_a_name(open_page):
    page = open_page()
    controls = page.locator("#explorer input, #explorer select, #explorer button, #explorer textarea")
    assert controls.count() >= 3 * 4 + 3
    for k in range(controls.count()):
        named = controls.nth(k).evaluate(
            "(e) => e.getAttribute('aria-label') || e.textContent || e.labels[0].textContent"
        )
        assert named.strip()


def test_outside_of_what_was_trained_it_says_so(open_page):
    page = open_page()
    assert page.locator("#explorer .warning").is_hidden()
    page.get_by_role("spinbutton", name="Bearing radius R*, Nominal, mm").fill("20.2")
    updated(page)
    assert page.locator("#explorer.outside").count() == 1
    assert (
        "by the bearing radius R* (trained from 19.85 to 20.15 mm)" in page.locator("#explorer .warning").inner_text()
    )


def test_the_joint_stands_at_its_tilt(open_page, directory):
    page = open_page()
    joint = run_directory.read(directory).study().scene.joint
    svg = page.locator("#explorer .joint svg")
    assert float(svg.get_attribute("data-tilt")) == pytest.approx(joint.tilt_angle, rel=1e-15)
    turned = svg.locator(".journal").get_attribute("transform")
    assert float(turned[7:-1]) == pytest.approx(-np.degrees(joint.tilt_angle), rel=1e-12)


def test_without_scripts_the_report_is_what_it_was(open_page):
    page = open_page(java_script_enabled=False)
    assert page.locator("#explorer").is_hidden()
    assert page.get_by_role("heading", name="Dimensions and tolerances").is_visible()
    assert "polynomials that" not in page.locator("body").inner_text()


@pytest.mark.parametrize("width", [320, 400, 800])
def test_fits_narrow_screens(open_page, width):
    page = open_page(viewport={"width": width, "height": 700})
    assert page.evaluate("document.getElementById('explorer').scrollWidth") <= width
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_is_dark_where_that_is_asked_for(open_page):
    brightness = [
        open_page(color_scheme=scheme).evaluate("getComputedStyle(document.body).backgroundColor")
        for scheme in ("light", "dark")
    ]
    assert brightness == ["rgb(255, 255, 255)", "rgb(20, 25, 31)"]


def test_is_printed_where_something_is_set(open_page):
    page = open_page()
    page.emulate_media(media="print")
    assert page.locator("#explorer").is_hidden()
    page.emulate_media(media="screen")
    page.get_by_role("spinbutton", name="Half length L, Tolerance ±, mm").fill("0.15")
    updated(page)
    page.emulate_media(media="print")
    assert page.locator("#explorer .share").is_visible()
    assert page.locator("#explorer input[type=range]").first.is_hidden()


def test_time_of_an_update(open_page, capsys):
    """Measured, not judged: other work on the machine would decide."""
    page = open_page()
    times = page.evaluate("""async () => {
        const slider = document.querySelector("#explorer input[type=range]"), found = [];
        for (let i = 0; i < 9; i++) {
            slider.value = Number(slider.value) + (i % 2 ? 1 : -1) * Number(slider.step);
            slider.dispatchEvent(new Event("input"));
            await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
            found.push(Number(document.getElementById("explorer").dataset.milliseconds));
        }
        return found;
    }""")
    outputs = page.locator("#explorer .output").count()
    with capsys.disabled():
        print(f"\n{PARTS:,} parts, {outputs} outputs: {np.median(times):.0f} ms an update, at best {min(times):.0f} ms")
    assert len(times) == 9 and min(times) > 0
