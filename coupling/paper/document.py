"""The report on the paper as one document, in Markdown and in HTML."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from os.path import relpath
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console

from coupling.errors import BadCase, Problem, unknown
from coupling.paper import checklist
from coupling.paper.entries import VERDICTS, Section, number
from coupling.paper.sections import SECTIONS, load
from coupling.paper.workshop import Workshop

NAME = "paper"
TITLE = "Hua et al. (2026), Aerospace 13(6), 529: what is printed, and what follows"
PREFACE = """
Each line takes a statement of the paper and says what is printed, what its printed inputs give
here (with its laws and its material), what the corrected physics gives, and the verdict. Nothing
is tuned to a printed number. What the paper does not give is assumed in the case and marked there;
where its inputs contradict themselves the reading that was taken is named.
"""
COLUMNS = ("where", "what", "printed", "from its inputs", "corrected physics", "verdict")
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 84rem; margin: 2rem auto; padding: 0 1rem;
       color: #1d2733 }
table { border-collapse: collapse; margin: 1rem 0 }
th, td { border-bottom: 1px solid #d5dde5; padding: .35rem .6rem; text-align: left;
         vertical-align: top }
th { border-bottom: 2px solid #1d2733 }
img { max-width: 100%; margin: .5rem 0 }
"""


def report(name: str | None, folder: Path, out: Console, large: bool = False) -> list[Path]:
    """Make the document, or that of one section; the files that were written.

    Parameters
    ----------
    name : of a section; None: all of them, and the checklist of components
    large : with what takes longer than minutes

    Raises
    ------
    BadCase : there is no such section
    """
    if name is not None and name not in SECTIONS:
        raise BadCase("report paper", [Problem("", unknown("section", name, SECTIONS))])
    folder.mkdir(parents=True, exist_ok=True)
    work = Workshop(folder, say=lambda text: out.print(f"  {text}", markup=False), large=large)
    sections = [_section(one, work, out) for one in ([name] if name else SECTIONS)]
    rows = checklist.rows(work, sections) if name is None else []
    return _written(folder, name, sections, rows)


def _section(name: str, work: Workshop, out: Console) -> Section:
    """Entries of a section; one that fails is said, and does not lose the others."""
    out.print(f"{name}", style="bold", markup=False)
    begun, found, failure = perf_counter(), [], ""
    try:
        for entry in load(name)(work):
            found.append(entry)
            out.print(f"  {entry.place}: {entry.claim}: {entry.verdict}", markup=False)
    except Exception as error:
        failure = f"{type(error).__name__}: {error}"
        out.print(f"  not finished: {failure}", style="red", markup=False)
    return Section(name, found, perf_counter() - begun, failure)


def _written(
    folder: Path, name: str | None, sections: Sequence[Section], rows: Sequence[checklist.Row]
) -> list[Path]:
    stem = NAME if name is None else f"{NAME}_{name}"
    text = "\n".join(_lines(folder, sections, rows)) + "\n"
    markdown, html = folder / f"{stem}.md", folder / f"{stem}.html"
    markdown.write_text(text, encoding="utf-8")
    html.write_text(_html(text), encoding="utf-8")
    return [markdown, html]


def _lines(
    folder: Path, sections: Sequence[Section], rows: Sequence[checklist.Row]
) -> Iterator[str]:  # fmt: skip
    yield from (f"# {TITLE}", PREFACE)
    yield from _summary(sections, rows)
    for section in sections:
        yield from _of_section(folder, section)
    if rows:
        yield from _of_checklist(rows)


def _summary(sections: Sequence[Section], rows: Sequence[checklist.Row]) -> Iterator[str]:
    """How many statements got which verdict, section by section."""
    yield from ("## Summary", "")
    yield from table(("section", *VERDICTS, "time [s]"), [_counts(s) for s in sections])
    total = Counter(entry.kind for section in sections for entry in section.entries)
    shown = ", ".join(f"{total[kind]} {kind}" for kind in VERDICTS)
    yield "Times are of making this document; what was kept from before took its time then."
    yield ""
    yield f"{sum(total.values())} statements: {shown}."
    if rows:
        good = sum(row.works for row in rows)
        yield f"{good} of {len(rows)} components of the checklist below work, each with a number."
    yield ""


def _counts(section: Section) -> tuple[str, ...]:
    found = Counter(entry.kind for entry in section.entries)
    name = f"[{section.name}](#{anchor(section.name)})"
    return (name, *(str(found[kind] or "") for kind in VERDICTS), number(section.seconds, "", 3))


def _of_section(folder: Path, section: Section) -> Iterator[str]:
    yield from (f"## {title(section.name)}", "")
    yield from table(COLUMNS, [entry[:6] for entry in section.entries])
    if section.failure:
        yield from (f"Not finished: {section.failure}", "")
    shown = dict.fromkeys(path for entry in section.entries for path in entry.pictures)
    for path in shown:
        yield from (f"![{path.stem.replace('_', ' ')}]({_relative(path, folder)})", "")


def _relative(path: Path, folder: Path) -> str:
    return Path(relpath(path.resolve(), folder.resolve())).as_posix()


def _of_checklist(rows: Sequence[checklist.Row]) -> Iterator[str]:
    yield from (
        "## Components",
        "",
        "Every component that the paper names, and a number of it.",
        "",
    )
    cells = [(str(r.number), r.text, "yes" if r.works else "**no**", r.shown) for r in rows]
    yield from table(("", "component", "works", "what shows it"), cells)


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """A table in Markdown."""
    yield "| " + " | ".join(columns) + " |"
    yield "|" + "---|" * len(columns)
    for row in rows:
        yield "| " + " | ".join(_cell(cell) for cell in row) + " |"
    yield ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def title(name: str) -> str:
    """Heading of a section."""
    return name.replace("_", " ").capitalize()


def anchor(name: str) -> str:
    """What links to the heading of a section."""
    return title(name).lower().replace(" ", "-")


def _html(text: str) -> str:
    from markdown_it import MarkdownIt

    body = MarkdownIt("commonmark").enable("table").render(text)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{TITLE}</title>'
        f"<style>{STYLE}</style></head><body>{_with_anchors(body)}</body></html>\n"
    )


def _with_anchors(body: str) -> str:
    """Headings of the second level with the names that links use."""

    def named(match: Any) -> str:
        return f'<h2 id="{anchor(match[1])}">{match[1]}</h2>'

    return re.sub(r"<h2>(.*?)</h2>", named, body)
