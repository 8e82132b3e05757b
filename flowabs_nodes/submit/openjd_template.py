"""Writes a run as a job template of Open Job Description (OpenJD), the format of AWS Deadline Cloud and others.

One step renders the frames, in chunks (extension TASK_CHUNKING); each task calls ``flowabs openjd-task``.
Source: https://github.com/OpenJobDescription/openjd-specifications, "2023-09 Template Schemas" and RFC 0001.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from flowabs_nodes.engine.job_builder import as_list, build_job
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_frames import NEIGHBOURS
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.engine.unit_params import reads_other_frames
from flowabs_nodes.errors import CommandError
from flowabs_nodes.submit.openjd_frames import to_openjd

#: How many frames a task has unless it is told.
CHUNK = 10
#: The most characters of a job's name, and of the default of one of its parameters.
_LONGEST_NAME, _LONGEST_TEXT = 64, 1024


def job_template(graph: str, options: RunOptions, *, chunk: int | None = None) -> dict[str, Any]:
    """Return the template of a job that runs ``graph``, a file or a shipped graph's name, ``chunk`` frames a task.

    Without a ``chunk`` it is 10; 24 where nodes read other frames, since each task computes those around its own again.

    ``options`` are what they are for a run; without ``frames`` the job gets those that are on disk now. The job's
    parameters are Graph, Input and Output (where these are files), Folder, Frames and ChunkSize. A file below the
    current folder is a PATH, relative to the folder where the template will be. Any other is a STRING and absolute:
    OpenJD takes no absolute default for a PATH.

    Raises
    ------
    GraphError, CommandError, ColorError
        What a run raises before its first frame; CommandError too where a word cannot be said in a template.
    """
    if options.scheduler is not None:
        text = "--scheduler is for a run: the tasks of a job are rendered by the machines that the farm gives them to"
        raise CommandError(text, code="bad-value", hint="leave it out", parameter="scheduler")
    loaded = load_graph(graph)
    if options.set:
        loaded = loaded.with_set(options.set)
    _, numbers = build_job(loaded, choose_config(options)[0], touch=False)
    if chunk is None:
        chunk = NEIGHBOURS if reads_other_frames(loaded) else CHUNK
    words, files = ["openjd-task", "--folder={{Param.Folder}}"], []

    def refer(name: str, path: str, flow: str) -> str:
        files.append(_file_parameter(name, path, flow))
        return f"{{{{Param.{name}}}}}"

    if options.input is not None:
        words.append(f"--input={refer('Input', os.fspath(options.input), 'IN')}")
    for count, path in enumerate(as_list(options.output), start=1):
        words.append(f"--output={refer(f'Output{count}' if count > 1 else 'Output', path, 'OUT')}")
    words += ["--frames={{Task.Param.Frame}}", *_further_words(options)]
    is_file = "/" in graph or os.sep in graph or graph.endswith(".json")
    words.append(refer("Graph", graph, "IN") if is_file else graph)
    folder = {"name": "Folder", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "NONE", "default": "."}
    frames = _short(to_openjd(numbers), "--frames")
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": _literal(f"flowabs {loaded.name}")[:_LONGEST_NAME],
        "parameterDefinitions": [
            *files,
            {**folder, "description": "Where names of files begin that are not absolute."},
            {"name": "Frames", "type": "STRING", "default": frames, "description": "Such as 1001-1100:2,1200."},
            {"name": "ChunkSize", "type": "INT", "minValue": 1, "default": chunk, "description": "Frames of one task."},
        ],
        "steps": [{"name": "Render", "parameterSpace": _FRAMES, "script": _script(words)}],
    }


_FRAMES = {
    "taskParameterDefinitions": [
        {
            "name": "Frame",
            "type": "CHUNK[INT]",
            "range": "{{Param.Frames}}",
            "chunks": {"defaultTaskCount": "{{Param.ChunkSize}}", "rangeConstraint": "NONCONTIGUOUS"},
        }
    ]
}


def _script(words: list[str]) -> dict[str, Any]:
    """Return the script of a step whose tasks call ``flowabs`` with ``words``; one that is cancelled may tidy up."""
    cancel = {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 30}
    return {"actions": {"onRun": {"command": "flowabs", "args": words, "cancelation": cancel}}}


def _file_parameter(name: str, path: str, flow: str) -> dict[str, str]:
    """Return the definition of a parameter that is a file or a sequence of files."""
    whole = os.path.abspath(path)
    here = os.getcwd()
    below = os.path.splitdrive(whole)[0] == os.path.splitdrive(here)[0] and os.path.relpath(whole, here)
    if not below or below.split(os.sep)[0] == os.pardir:
        return {"name": name, "type": "STRING", "default": _short(_literal(whole), path)}
    relative = _short(_literal(below.replace(os.sep, "/")), path)
    return {"name": name, "type": "PATH", "objectType": "FILE", "dataFlow": flow, "default": relative}


def _further_words(options: RunOptions) -> Iterator[str]:
    """Yield the words for all options that are not as they are without any, but for files and frames."""
    for option in fields(RunOptions):
        value = getattr(options, option.name)
        if option.name in ("input", "output", "frames") or value == option.default:
            continue
        if option.name == "set":
            for name, setting in value.items():
                yield _literal(f"--set={name}={json.dumps(setting, ensure_ascii=False)}")
        else:
            yield _literal(f"--{option.name.replace('_', '-')}={value}")


def _literal(word: str) -> str:
    """Return a word. Raises CommandError where OpenJD would read it as an expression: no escape is known to it."""
    if "{{" in word:
        raise CommandError(f"{word!r}: Open Job Description reads {{{{ as an expression", code="bad-value")
    return word


def _short(text: str, what: str) -> str:
    """Return the default of a parameter. Raises CommandError where it is longer than OpenJD allows."""
    if len(text) > _LONGEST_TEXT:
        raise CommandError(
            f"{what}: {len(text)} characters, of at most {_LONGEST_TEXT} in a parameter of Open Job Description",
            code="bad-value",
            hint="several jobs, each with a part of the frames" if what == "--frames" else "",
        )
    return text
