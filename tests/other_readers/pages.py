"""Pages of reports in a browser and on paper: silent, self-contained, accessible, narrow enough, printable, usable by keyboard.

usage: pages.py REPORT... --axe AXE.min.js --out FOLDER [--chromium PATH]

Needs playwright and pymupdf, an installed Chromium, and the file axe.min.js of axe-core 4. Every page of a report folder

- says nothing on the console and asks for no file outside the folder;
- says the same text where scripts are switched off;
- has no serious or critical violation of axe-core, light and dark, wide and narrow;
- does not scroll sideways at 360 px;
- loses no text on A4, and no figure is cut across two sheets;
- has a label on every readout of a figure, and shows it when the readout has the focus.

Screenshots and PDF files are left in FOLDER. The exit code is 1 where a page fails or a folder has none.
"""

import argparse
import collections
import dataclasses
import pathlib
import sys
import unicodedata
import urllib.parse

import pymupdf
from playwright.sync_api import Browser, BrowserContext, Error, Page, sync_playwright

WIDE, NARROW = 1280, 360
SEVERE = ("serious", "critical")

# A4 in CSS pixels, and the margins that pages are printed with: none, and the usual ones of a browser.
SHEET_WIDTH, SHEET_HEIGHT = 793.7, 1122.5
MARGINS_MM = (0.0, 10.0)
PX_PER_MM = 96 / 25.4

# Elements that reach beyond the window, widest first. What a scrolling or clipping box holds is the box's own affair.
BEYOND = """width => {
  const holds = e => getComputedStyle(e).overflowX !== 'visible';
  const isHeld = e => { for (let p = e.parentElement; p && p !== document.body; p = p.parentElement) if (holds(p)) return true; };
  const name = e => e.tagName.toLowerCase() + (e.id && '#' + e.id) + [...e.classList].map(c => '.' + c).join('');
  return [...document.body.querySelectorAll('*')]
    .filter(e => !isHeld(e))
    .map(e => [Math.ceil(e.getBoundingClientRect().right + scrollX), name(e)])
    .filter(([right]) => right > width).sort((a, b) => b[0] - a[0]).slice(0, 3);
}"""

# What paper should show: every printed text, and of every figure its title, its caption, all its text and its place among the images.
PRINTED = """() => {
  const isSeen = e => e.checkVisibility({visibilityProperty: true, opacityProperty: true});
  const texts = root => {
    const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT), found = [];
    while (walker.nextNode())
      if (walker.currentNode.data.trim() && isSeen(walker.currentNode.parentElement)) found.push(walker.currentNode.data);
    return found;
  };
  const images = [...document.images].filter(isSeen);
  const text = e => e && isSeen(e) ? texts(e).join(' ') : '';
  return {
    texts: texts(document.body),
    images: images.length,
    figures: [...document.querySelectorAll('figure')].filter(isSeen).map(f => ({
      id: f.id,
      height: f.getBoundingClientRect().height,
      title: text(f.querySelector('.title')),
      caption: text(f.querySelector('figcaption')),
      all: texts(f).join(' '),
      image: images.findIndex(i => f.contains(i)),
    })),
  };
}"""

READOUTS = """() => {
  const isSeen = e => e.checkVisibility({visibilityProperty: true, opacityProperty: true});
  const all = [...document.querySelectorAll('svg [tabindex="0"]')];
  const seen = new Set(), wrong = [];
  all.forEach((readout, i) => {
    const label = (readout.getAttribute('aria-label') || '').trim();
    const figure = readout.closest('figure');
    const name = `readout ${i + 1} of ${all.length}` + (figure && figure.id ? ` (in #${figure.id})` : '');
    if (!label) wrong.push(`${name} has no aria-label`);
    const tip = readout.querySelector('.tip');
    const isOpen = tip && isSeen(tip);
    readout.focus();
    if (document.activeElement !== readout) wrong.push(`${name} does not take the focus`);
    if (seen.has(readout.ownerSVGElement)) return;
    seen.add(readout.ownerSVGElement);
    document.getAnimations().forEach(animation => animation.finish());
    if (!tip) wrong.push(`${name} has no .tip`);
    else if (isOpen) wrong.push(`${name} shows its .tip without the focus`);
    else if (!isSeen(tip) || !tip.textContent.trim()) wrong.push(`${name} shows no .tip when focused`);
  });
  if (document.activeElement) document.activeElement.blur();
  return [all.length, wrong];
}"""

AXE = """async () => {
  const found = await axe.run(document);
  const targets = nodes => nodes.slice(0, 3).map(node => node.target.flat(Infinity).join(' ')).join(', ');
  return {
    passed: found.passes.length,
    violations: found.violations.map(v => [v.id, v.impact, v.nodes.length, targets(v.nodes)]),
  };
}"""


def bare(text: str) -> str:
    """Text without spaces, ligatures and case: what is left of it wherever its lines are broken."""
    return "".join(c for c in unicodedata.normalize("NFKC", text).casefold() if not c.isspace() and unicodedata.category(c) != "Cf")


def short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


class Ears:
    """What a page says and asks for."""

    def __init__(self, report: pathlib.Path):
        self.report, self.heard = report, collections.Counter()
        self.is_open = True

    def listen(self, context: BrowserContext):
        context.on("console", lambda message: self.note(f"console {message.type}: {short(message.text)}"))
        context.on("weberror", lambda error: self.note(f"page error: {short(str(error.error))}"))
        context.on("request", lambda request: self.is_own(request.url) or self.note(f"request to {request.url[:120]}"))
        context.on("requestfailed", lambda request: self.note(f"request failed: {request.url[:120]}"))
        context.on("page", lambda page: page.on("websocket", lambda socket: self.note(f"request to {socket.url[:120]}")))

    def note(self, what: str):
        if self.is_open:
            self.heard[what] += 1

    def is_own(self, url: str) -> bool:
        parts = urllib.parse.urlsplit(url)
        if parts.scheme in ("data", "blob"):
            return True
        path = pathlib.Path(urllib.parse.unquote(parts.path))
        return parts.scheme == "file" and not parts.netloc and path.resolve().is_relative_to(self.report)


class Paper:
    """A PDF file as one run of bare text that knows its sheets."""

    def __init__(self, path: pathlib.Path):
        self.beyond, self.starts, self.images, texts = [], [], [], []
        # The flags of words leave out what lies beyond the sheet, which is what is looked for.
        flags = pymupdf.TEXTFLAGS_WORDS & ~pymupdf.TEXT_MEDIABOX_CLIP
        with pymupdf.open(path) as document:
            self.n = len(document)
            for n, sheet in enumerate(document, 1):
                self.starts.append(sum(map(len, texts)))
                texts.append(bare(sheet.get_text(flags=pymupdf.TEXTFLAGS_TEXT & ~pymupdf.TEXT_MEDIABOX_CLIP)))
                self.images += [n] * len(sheet.get_image_info())
                for x0, _, x1, _, word, *_ in sheet.get_text("words", flags=flags):
                    if x1 >= sheet.rect.width or x0 < 0.0:
                        self.beyond.append(f"sheet {n}: {word!r} reaches x = {x1:.0f} pt of {sheet.rect.width:.0f} pt")
        self.texts, self.text = texts, "".join(texts)

    def sheet(self, at: int) -> int:
        return sum(start <= at for start in self.starts)

    def has(self, text: str) -> bool:
        """Whether text is there in one piece, or as the end of a box on one sheet and its continuation on the next."""
        return text in self.text or any(
            text[:cut] in one and text[cut:] in next_one
            for one, next_one in zip(self.texts, self.texts[1:])
            for cut in range(1, len(text))
            if text[:1] in one and text[-1:] in next_one
        )


def cut_figures(paper: Paper, printed: dict, tallest: float):
    """Figures whose head and last line are on different sheets."""
    if any(figure["image"] >= 0 for figure in printed["figures"]) and len(paper.images) != printed["images"]:
        yield f"{printed['images']} images are {len(paper.images)} on paper"
    end = 0
    for number, figure in enumerate(printed["figures"], 1):
        title, caption, image = bare(figure["title"]), bare(figure["caption"]), figure["image"]
        name = f"figure {number} ({short(figure['title'] or figure['caption']) or figure['id']})"
        if not caption or not (title or image >= 0):
            yield f"{name} has no caption, or neither a title nor an image, to find it by"
            continue
        start = paper.text.find(caption, end)
        if start < 0:
            yield f"{name}: its caption is not found"
            continue
        first, end = end, start + len(caption)
        last_sheet = paper.sheet(end - 1)
        if title:
            # A figure may say its title again, on an axis or in its caption: these come after the title itself.
            at = end
            for _ in range(bare(figure["all"]).count(title)):
                at = paper.text.rfind(title, first, at)
                if at < 0:
                    break
            if at < 0:
                yield f"{name}: its title is not found before its caption"
                continue
            first_sheet = paper.sheet(at)
        elif image < len(paper.images):
            first_sheet = paper.images[image]
        else:
            continue
        if first_sheet != last_sheet and figure["height"] <= tallest:
            yield f"{name} is cut: it begins on sheet {first_sheet} and ends on sheet {last_sheet}"


def on_paper(page: Page, path: pathlib.Path):
    """Prints a page with and without margins; the number of sheets, and what is wrong with them."""
    wrong, sheets = [], 0
    for margin in MARGINS_MM:
        lost_px = 2 * margin * PX_PER_MM
        width, height = SHEET_WIDTH - lost_px, SHEET_HEIGHT - lost_px
        page.set_viewport_size({"width": int(width), "height": int(height)})
        page.emulate_media(media="print")
        printed = page.evaluate(PRINTED)
        page.emulate_media(media="null")
        sides = dict.fromkeys(("top", "right", "bottom", "left"), f"{margin}mm")
        page.pdf(path=path, format="A4", margin=sides)
        paper = Paper(path)
        sheets = paper.n
        lost = [text for text in printed["texts"] if not paper.has(bare(text))]
        found = [*paper.beyond[:3], *(f"{short(text)!r} is not there as printed text" for text in lost[:3])]
        found += cut_figures(paper, printed, height)
        wrong += [f"A4, margins {margin:.0f} mm: {one}" for one in found]
    return sheets, wrong


def first_difference(one: str, other: str) -> str:
    pairs = zip(one.splitlines() + ["(end)"], other.splitlines() + ["(end)"])
    return next((f"{short(a)!r} and {short(b)!r}" for a, b in pairs if a != b), "their ends")


@dataclasses.dataclass
class Found:
    figures: int = 0
    readouts: int = 0
    rules: int = 0
    sheets: int = 0
    wrong: list[str] = dataclasses.field(default_factory=list)
    notes: list[str] = dataclasses.field(default_factory=list)


def photograph(page: Page, path: pathlib.Path):
    try:
        page.screenshot(path=path, full_page=True)
    except Error:
        # Chromium now and then fails to capture a long page on a busy machine; a page that cannot be captured fails twice.
        page.screenshot(path=path, full_page=True)


def look(browser: Browser, file: pathlib.Path, axe: pathlib.Path, stem: pathlib.Path, ears: Ears, found: Found):
    def opened(width: int, **options) -> Page:
        # Without a network a page is what it will be in a laboratory without one; what it asks for is heard all the same.
        context = browser.new_context(viewport={"width": width, "height": 900}, offline=True, **options)
        ears.is_open = True
        ears.listen(context)
        page = context.new_page()
        page.goto(file.as_uri(), wait_until="networkidle")
        return page

    page = opened(WIDE)
    text = page.locator("body").inner_text()
    found.figures = page.locator("figure").count()
    found.readouts, wrong = page.evaluate(READOUTS)
    found.wrong += [f"keyboard: {one}" for one in wrong]
    found.sheets, wrong = on_paper(page, stem.with_name(f"{stem.name}.pdf"))
    found.wrong += wrong
    page.context.close()

    page = opened(WIDE, java_script_enabled=False)
    unscripted = page.locator("body").inner_text()
    page.context.close()
    if not text.strip():
        found.wrong.append("the page says nothing")
    if text != unscripted:
        found.wrong.append(f"with and without scripts it says different things: {first_difference(text, unscripted)}")

    rules = []
    for scheme in ("light", "dark"):
        for width in (WIDE, NARROW):
            where = f"{scheme}, {width} px"
            page = opened(width, color_scheme=scheme, bypass_csp=True)
            if width == NARROW and (scrolls := page.evaluate("document.documentElement.scrollWidth")) > width:
                widest = ", ".join(f"{element} to {right} px" for right, element in page.evaluate(BEYOND, width))
                found.wrong.append(f"{where}: scrolls sideways to {scrolls} px: {widest or 'no element, but text'}")
            if width == WIDE or scheme == "light":
                photograph(page, stem.with_name(f"{stem.name}-{scheme}{'' if width == WIDE else f'-{width}'}.png"))
            # What axe-core says or asks for is not the page's.
            ears.is_open = False
            page.add_script_tag(path=axe)
            said = page.evaluate(AXE)
            rules.append(said["passed"])
            for rule, impact, n, targets in said["violations"]:
                to = found.wrong if impact in SEVERE else found.notes
                to.append(f"{where}: axe {rule} ({impact}), elements: {n}: {targets}")
            page.context.close()
    found.rules = min(rules)


def check(browser: Browser, report: pathlib.Path, file: pathlib.Path, axe: pathlib.Path, out: pathlib.Path) -> int:
    name = "-".join((report.name, *file.relative_to(report).with_suffix("").parts))
    ears, found = Ears(report), Found()
    try:
        look(browser, file, axe, out / name, ears, found)
    except Error as error:
        found.wrong.append(f"not looked at to the end: {' '.join(error.message.split())}")
    found.wrong += [f"{what} (times: {n})" for what, n in ears.heard.items()]
    print(
        f"{name}: {found.figures} figures, {found.readouts} readouts, {found.rules} axe rules passed, {found.sheets} sheets of A4:",
        f"FAIL, {len(found.wrong)}" if found.wrong else "ok",
    )
    for one in found.wrong:
        print(f"  FAIL {one}")
    for one in found.notes:
        print(f"  note {one}")
    sys.stdout.flush()
    return len(found.wrong)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reports", metavar="REPORT", nargs="+", type=pathlib.Path)
    parser.add_argument("--axe", required=True, type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    arguments = parser.parse_args()
    reports = [report.resolve() for report in arguments.reports]
    if len({report.name for report in reports}) < len(reports):
        parser.error("two reports have one name, and would overwrite each other's screenshots")
    arguments.out.mkdir(parents=True, exist_ok=True)
    failures = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=arguments.chromium, args=["--no-sandbox", "--disable-gpu", "--disable-quic"])
        for report in reports:
            files = sorted(report.rglob("*.html"))
            if not files:
                print(f"{report}: no page")
                failures += 1
            for file in files:
                failures += check(browser, report, file, arguments.axe, arguments.out)
        browser.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
