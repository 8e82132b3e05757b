"""Lets an operator work in the background: Blender stays usable, the status bar shows how far it is, Esc ends it.

Called from a script, such an operator waits for the end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from flowabs_nodes.errors import Cancelled, FlowabsError

from . import background
from .background import Background
from .messages import message

STEP = 0.05  # seconds between two looks at the work

#: The window timers of operators that look after work.
_timers: list[bpy.types.Timer] = []


class Attended:
    """Looks after work on behalf of an operator: what to show, and when it is over."""

    def __init__(self, work: Background[Any], title: str) -> None:
        self.work = work
        self._title = title

    def on_event(self, kind: str, value: str) -> bool:
        """Take an event of the window; return whether the work is over for the operator.

        Esc ends it at once for the operator: what is still at work stops by itself, and nobody hears of it.
        """
        if kind == "ESC" and value == "PRESS":
            self.work.cancel()
        return kind in ("TIMER", "ESC") and (self.work.cancelled or not self.work.running)

    @property
    def status(self) -> str:
        """Return what the status bar says."""
        compiling = "filters are compiled, once on this machine" if self.work.compiling else ""
        said = ", ".join(filter(None, [f"{self.work.progress:.0%}", self.work.text, compiling]))
        return f"{self._title}: {said}   (Esc cancels)"


class InBackground:
    """Makes an operator work in the background; mixed into operators, which say what to do and what comes of it."""

    def prepare(self, context: bpy.types.Context) -> Callable[[Background[Any]], Any]:
        """Return the work. Raises FlowabsError where it cannot begin."""
        raise NotImplementedError

    def finish(self, context: bpy.types.Context, made: Any) -> None:
        """Show what was made. Raises FlowabsError."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do the work and wait for its end."""
        work = self._begun(context)
        if work is None:
            return {"CANCELLED"}
        work.wait()
        return self._ended(context, work)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Begin the work, and look after it while Blender goes on; without a window wait for its end."""
        if bpy.app.background:
            return self.execute(context)
        work = self._begun(context)
        if work is None:
            return {"CANCELLED"}
        self._attended = Attended(work, self.bl_label)
        self._timer = context.window_manager.event_timer_add(STEP, window=context.window)
        _timers.append(self._timer)
        context.window_manager.modal_handler_add(self)
        self._tell(context, self._attended.status)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Show how far the work is; all but Esc is for others."""
        if not self._attended.on_event(event.type, event.value):
            if event.type == "TIMER":
                self._tell(context, self._attended.status)
            return {"PASS_THROUGH"}
        self._leave(context)
        return self._ended(context, self._attended.work)

    def cancel(self, context: bpy.types.Context) -> None:
        """End the work: Blender opens another file, or closes the window."""
        self._attended.work.cancel()
        self._leave(context)

    def _begun(self, context: bpy.types.Context) -> Background[Any] | None:
        try:
            return Background(self.prepare(context)).start()
        except FlowabsError as error:
            self.report({"ERROR"}, message(error))
            return None

    def _ended(self, context: bpy.types.Context, work: Background[Any]) -> set[str]:
        """Report how the work ended, and show what it made."""
        if work.cancelled:
            self.report({"INFO"}, f"{self.bl_label}: cancelled")
            return {"CANCELLED"}
        for level, text in work.notes:
            self.report({"WARNING" if level == "warning" else "INFO"}, text)
        try:
            self.finish(context, work.result())
        except Cancelled:
            return {"CANCELLED"}
        except FlowabsError as error:
            self.report({"ERROR"}, message(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _leave(self, context: bpy.types.Context) -> None:
        if self._timer in _timers:
            _timers.remove(self._timer)
            context.window_manager.event_timer_remove(self._timer)
        self._tell(context, None)

    def _tell(self, context: bpy.types.Context, text: str | None) -> None:
        """Show a text in the status bar, and the panels anew; None takes the text away."""
        if context.workspace is not None:
            context.workspace.status_text_set(text)
        for area in context.screen.areas if context.screen is not None else ():
            if area.type in ("NODE_EDITOR", "IMAGE_EDITOR"):
                area.tag_redraw()


def remove_timers() -> None:
    """Take away what operators have put into windows: Blender forgets an operator at work whose class goes."""
    while _timers:
        bpy.context.window_manager.event_timer_remove(_timers.pop())
    for workspace in bpy.data.workspaces:
        workspace.status_text_set(None)


class FLOWABS_OT_cancel(bpy.types.Operator):
    """End all that flowabs does in the background"""

    bl_idname = "flowabs.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is anything to end."""
        return bool(background.at_work())

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Ask it to end."""
        for work in background.at_work():
            work.cancel()
        return {"FINISHED"}


CLASSES = (FLOWABS_OT_cancel,)
