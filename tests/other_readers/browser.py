"""Pages of reports in a browser: quiet, whole without scripts, accessible, readable on a telephone and on paper, by pointer and keyboard.

usage: browser.py REPORT... --axe AXE.min.js --out FOLDER [--chromium PATH]

Every page of each report folder is opened from disk. What is asked of it:

- no message on the console, no error, no request but for files of the report;
- the same text with scripts switched off;
- no serious or critical violation by axe-core, in light and dark, wide and narrow;
- no horizontal scroll at 360 px;
- on A4 no figure is cut in two, and no word lies beyond the edge;
- every reading of a figure can be reached by keyboard, has a name, and shows what it says.

Screenshots and PDF files stay in the folder of `--out`.
"""

import argparse
import pathlib
import sys

import pymupdf
from playwright.sync_api import sync_playwright

WIDE, NARROW = {"width": 1280, "height": 900}, {"width": 360, "height": 740}

# What is wider than the window, and by how much.
WIDEST = """() => [...document.querySelectorAll('body *')]
  .filter(e => !e.closest('.scroll') || e.classList.contains('scroll'))
  .map(e => [e.getBoundingClientRect().right, e.tagName + '.' + (e.getAttribute('class') || '') + ' ' + (e.textContent || '').trim().slice(0, 40)])
  .filter(([right]) => right > innerWidth + 0.5).sort((a, b) => b[0] - a[0]).slice(0, 4)"""

# Readings of figures: how many, which have no name, and which show nothing when the keyboard comes to them.
READINGS = """() => {
  const all = [...document.querySelectorAll('svg [tabindex="0"]')];
  const unnamed = all.filter(e => !(e.getAttribute('aria-label') || '').trim()).length;
  const seen = new Set(), silent = [];
  for (const reading of all) {
    if (seen.has(reading.ownerSVGElement)) continue;
    seen.add(reading.ownerSVGElement);
    reading.focus();
    const tip = reading.querySelector('.tip');
    if (!tip || getComputedStyle(tip).visibility !== 'visible' || !tip.textContent.trim())
      silent.push(reading.getAttribute('aria-label'));
    reading.blur();
  }
  return {n: all.length, unnamed, silent};
}"""

# Every figure gets a word at its head and one at its foot, small and in the colour of the ground, so that both can be found on paper.
MARKERS = """() => {
  const figures = [...document.querySelectorAll('figure')];
  figures.forEach((figure, i) => {
    for (const [place, name] of [['afterbegin', 'head'], ['beforeend', 'foot']]) {
      const mark = document.createElement('span');
      mark.style.cssText = 'display:block;height:0;line-height:0;font-size:4px;overflow:visible;color:#888';
      mark.textContent = `q${name}${i}q`;
      figure.insertAdjacentElement(place, mark);
    }
  });
  return figures.map(figure => figure.getBoundingClientRect().height);
}"""

PAPER_PX = 960.0


def accessible(page, axe, where, wrong):
    page.evaluate(axe)
    found = page.evaluate("async () => { const r = await axe.run(document); return {ok: r.passes.length, bad: r.violations}; }")
    for violation in found["bad"]:
        if violation["impact"] in ("serious", "critical"):
            places = "; ".join(str(node["target"]) for node in violation["nodes"][:3])
            wrong.append(f"{where}: axe {violation['id']} ({violation['impact']}, {len(violation['nodes'])}): {places}")
    return found["ok"]


def on_paper(page, path, wrong):
    heights = page.evaluate(MARKERS)
    page.pdf(path=path, format="A4", print_background=True)
    with pymupdf.open(path) as paper:
        pages = [sheet.get_text() for sheet in paper]
        for n, sheet in enumerate(paper):
            words = [word for word in sheet.get_text("words") if word[2] > sheet.rect.width + 0.5 or word[0] < -0.5]
            if words:
                wrong.append(f"paper, page {n + 1}: {words[0][4]!r} lies beyond the edge")
    for i, height in enumerate(heights):
        at = [[n for n, text in enumerate(pages) if f"q{name}{i}q" in text] for name in ("head", "foot")]
        if not at[0] or not at[1]:
            wrong.append(f"paper: figure {i} is not there")
        elif at[0][0] != at[1][0] and height <= PAPER_PX:
            wrong.append(f"paper: figure {i} is cut: begins on page {at[0][0] + 1}, ends on {at[1][0] + 1}")
    return len(pages)


def check(browser, report, file, axe, out):
    name = f"{report.name}-{file.relative_to(report).with_suffix('')}".replace("/", "-")
    wrong, said, rules = [], [], 0
    texts = {}
    for scripts in (True, False):
        context = browser.new_context(viewport=WIDE, java_script_enabled=scripts)
        page = context.new_page()
        page.on("console", lambda message: said.append(f"console: {message.text}"))
        page.on("pageerror", lambda error: said.append(f"error: {error}"))
        inside = report.resolve().as_uri()
        page.on("request", lambda request: request.url.startswith((inside, "data:")) or said.append(f"request: {request.url[:120]}"))
        page.on("requestfailed", lambda request: said.append(f"not there: {request.url[:120]}"))
        page.goto(file.resolve().as_uri(), wait_until="load")
        texts[scripts] = page.locator("body").inner_text()
        context.close()
    if texts[True] != texts[False] or not texts[True].strip():
        wrong.append("without scripts the page says something else, or nothing")
    for scheme in ("light", "dark"):
        for window in (WIDE, NARROW):
            # The checker is no part of the page: what it would say is not the page's.
            context = browser.new_context(viewport=window, color_scheme=scheme)
            page = context.new_page()
            page.goto(file.resolve().as_uri(), wait_until="load")
            where = f"{scheme}, {window['width']} px"
            if window is NARROW:
                width = page.evaluate("document.documentElement.scrollWidth")
                if width > window["width"]:
                    wrong.append(f"{where}: scrolls to {width} px: {page.evaluate(WIDEST)}")
            if scheme == "light" or window is WIDE:
                page.screenshot(path=out / f"{name}-{scheme}-{window['width']}.png", full_page=True)
            rules = accessible(page, axe, where, wrong)
            context.close()
    page = browser.new_page(viewport=WIDE)
    page.goto(file.resolve().as_uri(), wait_until="load")
    figures = page.locator("figure").count()
    readings = page.evaluate(READINGS)
    if readings["unnamed"]:
        wrong.append(f"{readings['unnamed']} readings have no name")
    wrong.extend(f"keyboard: {silent!r} shows nothing" for silent in readings["silent"])
    sheets = on_paper(page, out / f"{name}.pdf", wrong)
    page.close()
    wrong.extend(said)
    print(f"{name}: {figures} figures, {readings['n']} readings, {sheets} sheets of A4, {rules} rules of axe pass, {len(wrong)} failures")
    for one in wrong:
        print(f"  {one}")
    return len(wrong)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("reports", nargs="+", type=pathlib.Path)
    parser.add_argument("--axe", required=True, type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    axe = arguments.axe.read_text()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=arguments.chromium, args=["--no-sandbox", "--disable-gpu", "--disable-quic"]
        )
        failures = 0
        for report in arguments.reports:
            files = sorted(report.rglob("*.html"))
            if not files:
                sys.exit(f"{report}: no page")
            failures += sum(check(browser, report, file, axe, arguments.out) for file in files)
        browser.close()
    if failures:
        sys.exit(f"{failures} failures")


main()
