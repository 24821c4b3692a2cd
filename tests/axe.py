"""axe-core on what a lesson shows in JupyterLab, whose own frame is left out."""

from importlib.util import find_spec
from pathlib import Path

from conftest import ROOT, skip_unless_ci

PAGE = ROOT / "stereo_lab" / "widgets" / "page"
# What is shown is copied out of the frame: in it, everything scrolls out of sight, and axe judges no colour that it cannot see.
JUDGE = """async node => {
    const all = [...eval(node).querySelectorAll(".jp-MarkdownOutput, .jp-OutputArea-output")];
    const page = document.createElement("div");
    page.id = "shown";
    page.className = "jp-Notebook";
    page.style.cssText = "width: 1000px; height: auto; overflow: visible; background: var(--jp-layout-color0)";
    for (const piece of all.filter(p => !p.parentElement.closest(".jp-OutputArea-output"))) page.append(piece.cloneNode(true));
    document.getElementById("main").style.display = "none";
    document.documentElement.style.overflow = "visible";
    document.body.style.cssText = "overflow: visible; height: auto";
    document.body.append(page);
    const found = await axe.run("#shown");
    page.remove();
    document.getElementById("main").style.display = "";
    const told = found.violations.filter(v => ["serious", "critical"].includes(v.impact));
    const judged = Object.fromEntries(found.passes.map(p => [p.id, p.nodes.length]));
    return [told.map(v => `${v.id}: ${v.nodes.map(n => n.html.slice(0, 200)).join(" | ")}`), judged];
}"""


def judged(page, node):
    """(what is serious or critical, how many pieces each rule passed) in a notebook that JavaScript's ``node`` gives."""
    found = find_spec("axe_playwright_python")
    if found is None:
        skip_unless_ci("axe-core is not installed: extra browser")
    if not page.evaluate("() => Boolean(window.axe)"):
        page.add_script_tag(path=Path(found.origin).parent / "axe.min.js")
    return page.evaluate(JUDGE, node)


def serious(page, node):
    """What is serious or critical there."""
    return judged(page, node)[0]
