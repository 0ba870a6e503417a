"""Work on one clip, and its failure as a result: one clip's failure does not stop others."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TypeVar

from footfix.batch.task import FileResult, Task
from footfix.errors import FootfixError, InputError

Made = TypeVar("Made")


def attempted(task: Task, work: Callable[[], Made]) -> Made | FileResult:
    """Return the result of some work on a clip, or a result that says why it failed."""
    source = task.job.source
    try:
        return work()
    except InputError as error:
        return FileResult(source, "failed", error=str(error), line=error.line)
    except FootfixError as error:
        return FileResult(source, "failed", error=str(error))
    except MemoryError:
        return FileResult(source, "failed", error=f"{source}: not enough memory for this clip")
    except OSError as error:
        return FileResult(source, "failed", error=f"{source}: {error.strerror or error}")
    except Exception as error:
        if os.environ.get("FOOTFIX_DEBUG"):
            raise
        text = f"{source}: a bug in footfix, not in your file: {type(error).__name__}: {error}"
        return FileResult(source, "failed", error=text, bug=True)
