"""The page of a run in a browser: wide and narrow, light and dark."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from stored_runs import stored_run

from graspdsl.report.claims import Claim
from graspdsl.report.evidence import evidence_of
from graspdsl.report.judgements import Verdict
from graspdsl.report.page import FIGURES, write_report
from graspdsl.report.summary import summarised

SPEC = Path(__file__).resolve().parents[2] / "specs" / "compare" / "moment_subject_to_force.yaml"
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
OFFLINE = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SAID = "<script>document.title='taken'</script>"
AA = 4.5  # contrast of text with its ground, WCAG 2

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium here to open a page in"),
]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run, some of whose trials do not converge, with scripts where texts should be."""
    settings = ("trials.count=12", "program.0.limit=1.1", f"about={SAID}", f"scene.object.name={SAID}")
    folder = stored_run(tmp_path_factory.mktemp("page") / "run", SPEC, *settings)
    long = "x " * 60
    claim = Claim("one", long, "s", long, "b", long, long, Verdict.UNTOLD, None, long, long)
    evidence = evidence_of(folder)
    return write_report(evidence, summarised(evidence), claims=[claim])


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A browser without a window or a network."""
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=OFFLINE)
        yield opened
        opened.close()


@pytest.fixture(params=[("light", 1280), ("light", 400), ("dark", 1280), ("dark", 400)], ids=str)
def opened(request: pytest.FixtureRequest, browser: Browser, report: Path) -> Iterator[Page]:
    """The page, open; closing it fails the test when the browser complained of anything, or asked for another file."""
    scheme, width = request.param
    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    complaints: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(report.as_uri())
    yield page
    page.close()
    assert (complaints, asked) == ([], [report.as_uri()])


def test_nothing_is_wider_than_the_window(opened: Page) -> None:
    whole, window = opened.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
    assert whole <= window


def test_every_figure_is_there(opened: Page, report: Path) -> None:
    files = sorted(report.parent.joinpath(FIGURES).glob("*.svg"))
    boxes = [figure.bounding_box() for figure in opened.locator("svg.figure").all()]
    assert len(boxes) == len(files) >= 3
    assert all(box is not None and box["width"] > 300 and box["height"] > 100 for box in boxes)
    assert all(caption.inner_text() for caption in opened.locator("figcaption").all())


def test_a_click_on_a_header_sorts(opened: Page) -> None:
    head = opened.locator("#trials th", has_text="orientation, start")
    column = head.evaluate("cell => cell.cellIndex")
    cells = opened.locator(f"#trials tbody td:nth-child({column + 1})")
    head.get_by_role("button").click()
    assert head.get_attribute("aria-sort") == "ascending"
    rising = [float(cell) for cell in cells.all_inner_texts()]
    assert rising == sorted(rising)
    assert len(set(rising)) > 2
    head.get_by_role("button").press("Enter")
    assert head.get_attribute("aria-sort") == "descending"
    assert [float(cell) for cell in cells.all_inner_texts()] == rising[::-1]
    other = opened.locator("#trials th", has_text="converge")
    other.get_by_role("button").click()
    assert head.get_attribute("aria-sort") is None
    where = other.evaluate("cell => cell.cellIndex")
    ticks = opened.locator(f"#trials tbody td:nth-child({where + 1})").all_inner_texts()
    known = [float(tick) for tick in ticks if tick != "–"]
    assert known == sorted(known)
    assert 0 < len(known) < len(ticks)
    assert set(ticks[len(known) :]) == {"–"}  # what is not known comes last


def test_a_script_in_the_spec_is_text(opened: Page) -> None:
    assert opened.title() == "compare-moment-subject-to-force: report"
    assert opened.locator("p.about").inner_text() == SAID
    assert SAID in opened.locator("header dl").inner_text()
    assert opened.locator("script").count() == 1


# The least contrast of a text with the ground behind it, of text in HTML and in figures; WCAG 2's formula.
CONTRAST = """() => {
  const channels = colour => colour.match(/[\\d.]+/g).map(Number);
  const linear = c => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  const luminance = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const ground = element => {
    for (let at = element; at; at = at.parentElement) {
      const found = channels(getComputedStyle(at).backgroundColor);
      if (found.length === 3 || found[3] === 1) return found;
    }
  };
  const ratios = [...document.querySelectorAll("body *")].filter(element =>
    element.tagName !== "SCRIPT" && [...element.childNodes].some(node => node.nodeType === 3 && node.data.trim())
  ).map(element => {
    const style = getComputedStyle(element);
    const colour = element.closest("svg") ? style.fill : style.color;
    const [a, b] = [luminance(channels(colour)), luminance(ground(element))];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  });
  return [ratios.length, Math.min(...ratios)];
}"""


def test_text_stands_out_from_its_ground(opened: Page) -> None:
    count, least = opened.evaluate(CONTRAST)
    assert count > 100
    assert least >= AA


def test_on_paper_it_is_light_and_whole(opened: Page) -> None:
    opened.emulate_media(media="print")
    assert opened.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert opened.locator("#trials .wide").evaluate("box => getComputedStyle(box).maxHeight") == "none"
