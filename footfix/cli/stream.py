"""`footfix stream`: a live BVH in, a corrected one out, after a fixed look-ahead."""

from __future__ import annotations

import math
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from footfix.cli.options import Common, shared
from footfix.cli.running import config_near
from footfix.cli.stderr import say
from footfix.errors import ExitCode, OutputError, UsageError

if TYPE_CHECKING:
    from footfix.formats.bvh.document import Document
    from footfix.settings import Settings
    from footfix.stream.sources import Peer


def _seconds(context: click.Context, option: click.Parameter, value: str) -> float:
    try:
        seconds = float(value)
    except ValueError:
        seconds = -1.0
    if not seconds >= 0.0:
        raise click.BadParameter(f"{value!r} is no time in seconds, such as 0.15, nor inf", context, option)
    return seconds


@click.command()
@click.option("--look-ahead", default="0.15", show_default=True, metavar="SECONDS", callback=_seconds,
              help="For how long a frame waits for what follows it; inf waits for the end, and writes what "
              "clean writes.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
              help="Where the rows go; standard output by default.")
@click.option("--events", metavar="FILE|-", help="A line of JSON for each strike and lift, as soon as it is known.")
@click.option("--listen", metavar="tcp://HOST:PORT", help="Rows come from a peer that connects here, and go back to "
              "it, too; 127.0.0.1 by default.")  # fmt: skip
@click.option("--connect", metavar="HOST:PORT", help="Rows come from a peer there, as Axis Neuron sends them as text.")
@click.option("--once", is_flag=True, help="End when the first peer goes; else the next one is waited for.")
@click.option("--calibrate", type=click.Path(exists=True, dir_okay=False, path_type=Path), metavar="FILE.bvh",
              help="A clip of the same figure, on which legs, floor and unit are measured; and the header of rows that "
              "come without one.")  # fmt: skip
@click.option("--calibration", default="2", show_default=True, metavar="SECONDS", callback=_seconds,
              help="Without --calibrate, how much of the stream legs, floor and unit are measured on.")
@click.option("--before", type=click.Choice(["pass", "wait"]), default="pass", show_default=True,
              help="Frames before calibration pass as they are, or wait and are corrected, too.")
@shared
def stream(
    look_ahead: float, output: Path | None, events: str | None, listen: str | None, connect: str | None, once: bool,
    calibrate: Path | None, calibration: float, before: Any, common: Common,
) -> int:  # fmt: skip
    """Take the foot skate out of a live figure.

    A BVH file is read from standard input as it comes in, a header and then a row a frame, and written to standard
    output a row for a row, after a fixed look-ahead.

    \b
    footfix stream < live.bvh > clean.bvh
    footfix stream --connect 127.0.0.1:7001 --calibrate walk.bvh --events - -o clean.bvh
    """
    if common.as_json:
        raise UsageError("a stream has no --json document; --events writes strikes and lifts as lines of JSON")
    if events == "-" and output is None and not listen:
        raise UsageError("--events - takes standard output: name a file for the rows with -o")
    settings = config_near([] if calibrate is None else [str(calibrate)], common, {}).settings(None)
    if math.isinf(look_ahead):
        if listen or connect or events:
            raise UsageError("--look-ahead inf waits for the end of a file on standard input, and has no --events")
        return _whole(settings, output)
    return _live(
        settings, common, look_ahead, calibration, before, calibrate, once,
        output=output, events=events, listen=listen, connect=connect,
    )  # fmt: skip


def _whole(settings: Settings, output: Path | None) -> int:
    """Wait for the end, and write what `clean` writes."""
    from footfix.batch.file_io import write_whole
    from footfix.jobs.clean import clean_file

    data = sys.stdin.buffer.read()
    motion = clean_file(data, "<stdin>", settings).motion
    if output is not None:
        write_whole(output, motion)
    else:
        sys.stdout.buffer.write(motion)
        sys.stdout.buffer.flush()
    return ExitCode.DONE


def _live(
    settings: Settings, common: Common, look_ahead: float, calibration: float, before: Any, calibrate: Path | None,
    once: bool, *, output: Path | None, events: str | None, listen: str | None, connect: str | None,
) -> int:  # fmt: skip
    from footfix.stream.backlog import Backlog
    from footfix.stream.interrupts import interrupts
    from footfix.stream.run import Run, Sink, Talk
    from footfix.stream.session import StreamParams
    from footfix.stream.sources import Address, Peer, Source, Standard, droppable

    def tell(text: str) -> None:
        if not common.quiet:
            say(f"footfix: {text}")

    known = _document(calibrate, settings) if calibrate else None
    network = bool(listen or connect)
    backlog = Backlog(drops=network, droppable=droppable)
    sources: list[Source] = []
    server: Peer | None = None
    standard = Standard(backlog, known, sys.stdin.fileno(), alone=not network)
    if connect:
        sources.append(Peer(backlog, known, Address.parsed(connect), listens=False, once=once, told=tell))
    elif not sys.stdin.isatty() or not network:
        sources.append(standard)
    if listen:
        server = Peer(
            backlog, known, Address.parsed(listen), listens=True, once=once, told=tell,
            hears=lambda: not connect and not standard.spoke,
        )  # fmt: skip
        sources.append(server)
    params = StreamParams(look_ahead=look_ahead, calibration=calibration, before=before)
    with ExitStack() as files:
        interrupted = files.enter_context(interrupts())
        rows = _opened(files, output) if output else None if events == "-" else sys.stdout.buffer
        told = sys.stdout.buffer if events == "-" else _opened(files, Path(events)) if events else None
        work = Run(
            settings, params, known, Sink(rows, drops=network) if rows else None,
            Sink(told, drops=network) if told else None, Talk(tell), server,
            interrupted,
        )  # fmt: skip
        for source in sources:
            source.start()
        work.run(backlog, sources)
    return ExitCode.DONE


def _document(path: Path, settings: Settings) -> Document:
    """Read a file of the figure, in metres and y up."""
    from footfix.batch.file_io import read_whole
    from footfix.formats.bvh.document import Document
    from footfix.jobs.source import read

    document = read(read_whole(path, settings.limits.bytes), str(path), settings)
    if not isinstance(document, Document):
        raise UsageError(f"{path} is no BVH file")
    return document


def _opened(files: ExitStack, path: Path) -> IO[bytes]:
    try:
        return files.enter_context(path.open("wb", buffering=0))
    except OSError as error:
        raise OutputError(f"can't write {path}: {error.strerror or error}") from None
