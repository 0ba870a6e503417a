"""The last message of a command that writes files: what it wrote, and which page to open."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from footfix.batch.task import PAGE, FileResult
from footfix.cli.options import Common
from footfix.cli.stderr import say
from footfix.errors import ExitCode
from footfix.report.text import printable


def print_result(result: FileResult, common: Common) -> ExitCode:
    """Print the result of a command that made one clip, and return its exit code.

    Args:
        result: of the clip.
        common: how much is printed, and whether as JSON.
    """
    from footfix.cli.running import plain, print_json
    from footfix.report.text import summarize

    if common.as_json:
        print_json({"format": "footfix-run", "version": 1, "files": [plain(result)]})
    if result.error:
        say(f"footfix: {result.error}")
        return ExitCode.BUG if result.bug else ExitCode.FAILED
    if not common.quiet and not common.as_json:
        say(summarize(result.report, verbose=common.verbose))
        text = wrote([result], every=common.verbose)
        if text:
            say(text)
    sys.stdout.flush()
    return ExitCode.DONE


def wrote(results: Sequence[FileResult], *, extra: Iterable[Path] = (), hint: str = "", every: bool = False) -> str:
    """Name in one line the clip or folder that was written, and the page to open; "" if nothing was written.

    Args:
        results: of all clips; those done by an earlier run are counted.
        extra: files of the whole run; a page among them is the one to open.
        hint: added at the end where there is no such page.
        every: name every file, a line each.
    """
    whole = [str(path) for path in extra]
    anew = [result for result in results if not result.skipped]
    files = [*(path for result in anew for path in result.written), *whole]
    before = len(results) - len(anew)
    done = f"{before} {'clip was' if before == 1 else 'clips were'} done before" if before else ""
    if not files:
        return done
    pages = [path for path in whole if path.endswith(".html")]
    if len(results) == 1 and not pages:
        pages = [path for path in results[0].written if path.endswith(PAGE)]
    if every:
        text = "\n".join(f"wrote {printable(path)}" for path in files)
    elif len(results) == 1 and not whole:
        first = _motion(results[0])
        text = f"wrote {printable(first)}" + (f" and {len(files) - 1} more beside it" if len(files) > 1 else "")
    else:
        text = f"wrote {len(files)} files to {printable(_common(files))}"
    last = f"open {printable(pages[0])}" if pages else hint
    text = f"{done}; {text}" if done else text
    return text + ("\n" if every and last else "; " if last else "") + last


def _motion(result: FileResult) -> str:
    """Find the corrected clip among the files of one."""
    return next((path for path in result.written if not path.endswith((".json", ".html", ".png"))), result.written[0])


def _common(files: Sequence[str]) -> str:
    """Find the nearest folder that holds all files."""
    folders = [Path(path).parent for path in files]
    nearest = folders[0]
    while not all(nearest in (folder, *folder.parents) for folder in folders) and nearest != nearest.parent:
        nearest = nearest.parent
    return str(nearest)
