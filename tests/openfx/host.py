"""A strict host of OpenFX 1.4 in ctypes: it loads a plug-in as Nuke or Resolve would, and notes whatever breaks a rule.

Every call is checked: the handle is of the right kind and alive, the property exists on that object, has that type, and
may be set; clips and parameters are defined while describing, images are taken while rendering and given back before
the action ends. What breaks a rule is a line in :attr:`Host.faults`.
"""

from __future__ import annotations

import contextlib
import ctypes as c
import itertools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from tests.openfx import properties
from tests.openfx.images import Held
from tests.openfx.properties import Property

OK, FAILED, FATAL, UNKNOWN, MISSING, UNSUPPORTED, EXISTS, FORMAT, MEMORY, BAD_HANDLE, BAD_INDEX, VALUE = range(12)
NO, DEFAULT, IMAGE_FORMAT = 13, 14, 1000

FILTER, GENERAL = "OfxImageEffectContextFilter", "OfxImageEffectContextGeneral"

_TYPES = {"int": c.c_int, "double": c.c_double, "string": c.c_char_p, "pointer": c.c_void_p}
_MANY = ("pointer", "string", "double", "int")
_P = c.POINTER
_V = c.c_void_p


class OfxHost(c.Structure):
    _fields_ = (("host", _V), ("fetchSuite", c.CFUNCTYPE(_V, _V, c.c_char_p, c.c_int)))


class OfxPlugin(c.Structure):
    _fields_ = (
        ("pluginApi", c.c_char_p),
        ("apiVersion", c.c_int),
        ("pluginIdentifier", c.c_char_p),
        ("pluginVersionMajor", c.c_uint),
        ("pluginVersionMinor", c.c_uint),
        ("setHost", c.CFUNCTYPE(None, _P(OfxHost))),
        ("mainEntry", c.CFUNCTYPE(c.c_int, c.c_char_p, _V, _V, _V)),
    )


class Properties:
    """A property set: which properties there are, and their values."""

    def __init__(self, known: dict[str, Property], **values: list[Any]) -> None:
        self.known, self.values, self.strings = known, dict(values), {}

    def get(self, name: str, index: int = 0, default: Any = None) -> Any:
        """Return a value, or ``default``."""
        values = self.values.get(name, [])
        return values[index] if index < len(values) else default


class Described:
    """A clip or a parameter as a plug-in describes it."""

    def __init__(self, name: str, kind: str, props: Properties) -> None:
        self.name, self.kind, self.props = name, kind, props


class Descriptor:
    """A plug-in as it describes itself, for one context or for all."""

    def __init__(self) -> None:
        self.props = Properties(properties.DESCRIPTOR, OfxPropType=["OfxTypeImageEffect"])
        self.clips: dict[str, Described] = {}
        self.params: dict[str, Described] = {}


class Host:
    """A host with one library of plug-ins loaded.

    Parameters
    ----------
    library
        The file of the plug-ins.
    without
        Names of suites that the host lacks, such as "OfxMessageSuite" or "OfxMessageSuite 2".
    depths
        The bit depths that the host says it supports.
    """

    def __init__(
        self,
        library: Path,
        *,
        without: Iterable[str] = (),
        depths: Iterable[str] = ("OfxBitDepthFloat", "OfxBitDepthHalf", "OfxBitDepthByte"),
    ) -> None:
        self.faults: list[str] = []
        self.log: list[str] = []
        self.messages: list[tuple[str, str]] = []  # kind, text: those that do not stay
        self.persistent: dict[int, tuple[str, str]] = {}  # by the instance's handle
        self.progress: list[float] = []
        self.progress_open = 0
        self.aborts: Callable[[], bool] = lambda: False
        self.cancel_bar = False
        self.taken = self.given_back = 0
        self.action = ""
        self._objects: dict[int, Any] = {}
        self._numbers = itertools.count(0x1000, 16)
        self._keep: list[Any] = []
        self._without = set(without)
        self._images: set[int] = set()
        values = {
            "OfxPropType": ["OfxTypeImageEffectHost"],
            "OfxPropName": ["org.flowabs.testhost"],
            "OfxImageEffectPropSupportedPixelDepths": list(depths),
            "OfxParamHostPropSupportsStringAnimation": [0],
            "OfxParamHostPropSupportsChoiceAnimation": [1],
            "OfxParamHostPropSupportsBooleanAnimation": [1],
        }
        self.props = Properties(properties.HOST, **values)
        self._suites = self._make_suites()
        self.structure = OfxHost(self.handle(self.props), OfxHost._fields_[1][1](self._fetch))
        self.library = c.CDLL(str(library))
        self.library.OfxGetPlugin.restype = _P(OfxPlugin)
        count = self.library.OfxGetNumberOfPlugins()
        self.plugins = [Plugin(self, self.library.OfxGetPlugin(i).contents) for i in range(count)]
        if self.library.OfxGetPlugin(count) or self.library.OfxGetPlugin(-1):
            self.fault("OfxGetPlugin gives a plug-in beyond the last")

    def plugin(self, name: str) -> Plugin:
        """Return a plug-in by the last part of its identifier."""
        return next(each for each in self.plugins if each.identifier.endswith(f".{name}"))

    def fault(self, text: str) -> None:
        """Note that the plug-in broke a rule."""
        self.faults.append(f"{self.action}: {text}" if self.action else text)

    def handle(self, thing: Any) -> int:
        """Return a new handle for an object."""
        number = next(self._numbers)
        self._objects[number] = thing
        return number

    def drop(self, number: int) -> None:
        """Make a handle invalid."""
        self._objects.pop(number, None)

    def of(self, number: int | None, kind: type, call: str) -> Any:
        """Return the object of a handle; None, and a fault, where it is none of its kind."""
        found = self._objects.get(number or 0)
        if not isinstance(found, kind):
            self.fault(f"{call}: {number} is no handle of a {kind.__name__}, but of {type(found).__name__}")
            return None
        return found

    def close(self) -> None:
        """Unload the plug-ins; then all images must be back."""
        for plugin in self.plugins:
            plugin.unload()
        if self.taken != self.given_back:
            self.fault(f"{self.taken} images taken, {self.given_back} given back")

    def __enter__(self) -> Host:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    # ------------------------------------------------------------------ suites

    def _fetch(self, host: int, name: bytes, version: int) -> int | None:
        if self.action != "OfxActionLoad":
            self.fault(f"fetchSuite of {name.decode()} outside of OfxActionLoad")
        text = name.decode()
        if text in self._without or f"{text} {version}" in self._without:
            return None
        suite = self._suites.get((text, version))
        return None if suite is None else c.addressof(suite)

    def _function(self, result: Any, *arguments: Any) -> Callable[[Callable[..., Any]], int]:
        """Return what turns a function of Python into the address of one of C."""
        kind = c.CFUNCTYPE(result, *arguments)

        def made(function: Callable[..., Any]) -> int:
            def guarded(*given: Any) -> Any:
                try:
                    return function(*given)
                except Exception as error:  # noqa: BLE001 - C has no exceptions: it is a fault of the host's
                    self.fault(f"the host failed in {function.__name__}: {error!r}")
                    return FATAL

            callback = kind(guarded)
            self._keep.append(callback)
            return c.cast(callback, _V).value or 0

        return made

    def _suite(self, *functions: int) -> Any:
        return (_V * len(functions))(*functions)

    def _make_suites(self) -> dict[tuple[str, int], Any]:
        from tests.openfx import suites

        return {
            ("OfxPropertySuite", 1): self._suite(*suites.property_suite(self)),
            ("OfxImageEffectSuite", 1): self._suite(*suites.effect_suite(self)),
            ("OfxParameterSuite", 1): self._suite(*suites.parameter_suite(self)),
            ("OfxMessageSuite", 1): self._suite(*suites.message_suite(self)[:1]),
            ("OfxMessageSuite", 2): self._suite(*suites.message_suite(self)),
            ("OfxProgressSuite", 1): self._suite(*suites.progress_suite(self)),
        }

    # ------------------------------------------------------------------ actions

    @contextlib.contextmanager
    def _in_action(self, name: str) -> Any:
        self.action, before, images = name, self.action, set(self._images)
        yield
        if self._images - images:
            self.fault(f"{len(self._images - images)} images were not given back")
        self.action = before


class Plugin:
    """A plug-in: it is loaded, and describes itself in the contexts that it supports."""

    def __init__(self, host: Host, structure: OfxPlugin) -> None:
        self.host, self.structure = host, structure
        self.identifier = structure.pluginIdentifier.decode()
        self.contexts: dict[str, Descriptor] = {}
        if structure.pluginApi != b"OfxImageEffectPluginAPI" or structure.apiVersion != 1:
            host.fault(f"{self.identifier}: wrong API {structure.pluginApi} {structure.apiVersion}")
        structure.setHost(c.byref(host.structure))
        self.loaded = False
        self.status = self.call("OfxActionLoad", None)
        if self.status not in (OK, DEFAULT):
            return
        self.loaded = True
        self.descriptor = Descriptor()
        self.status = self.call("OfxActionDescribe", self.descriptor)
        if self.status != OK:
            return
        props = self.descriptor.props
        for name in ("SupportedContexts", "SupportedPixelDepths"):
            if not props.get(f"OfxImageEffectProp{name}"):
                host.fault(f"{self.identifier}: {name} not set")
        for context in props.values.get("OfxImageEffectPropSupportedContexts", []):
            made = Descriptor()
            self.contexts[context] = made
            arguments = Properties(properties.CONTEXT_IN, OfxImageEffectPropContext=[context])
            status = self.call("OfxImageEffectActionDescribeInContext", made, arguments)
            if status != OK:
                host.fault(f"{self.identifier}: DescribeInContext {status}")
            self._check(made)

    def _check(self, made: Descriptor) -> None:
        """Check what has to be there, and that values lie within their ranges."""
        for name in ("Source", "Output"):
            if name not in made.clips:
                self.host.fault(f"{self.identifier}: no clip {name}")
        for clip in made.clips.values():
            if not clip.props.get("OfxImageEffectPropSupportedComponents"):
                self.host.fault(f"{self.identifier}: clip {clip.name} supports no components")
        for param in made.params.values():
            value, props = param.props.get("OfxParamPropDefault"), param.props
            low, high = props.get("OfxParamPropMin", 0, value), props.get("OfxParamPropMax", 0, value)
            if param.kind in ("OfxParamTypeDouble", "OfxParamTypeInteger") and not low <= value <= high:
                self.host.fault(f"{self.identifier}: {param.name}: {value} is not within {low} to {high}")
            options = props.values.get("OfxParamPropChoiceOption", [])
            if param.kind == "OfxParamTypeChoice" and not 0 <= value < len(options):
                self.host.fault(f"{self.identifier}: {param.name}: no choice {value} of {len(options)}")

    def call(self, action: str, subject: Any, given: Properties | None = None, wanted: Properties | None = None) -> int:
        """Call an action on a descriptor, an instance, or a handle as it is; return its status."""
        made = [self.host.handle(each) if each is not None else None for each in (given, wanted)]
        if isinstance(subject, Descriptor):
            subject = self.host.handle(subject)
        with self.host._in_action(action):
            status: int = self.structure.mainEntry(action.encode(), subject, *made)
        for number in made:
            if number is not None:
                self.host.drop(number)
        self.host.log.append(f"{self.identifier} {action} -> {status}")
        return status

    def unload(self) -> None:
        """Unload the plug-in, once."""
        if self.loaded:
            self.loaded = False
            self.call("OfxActionUnload", None)

    def instance(self, context: str = FILTER) -> Instance:
        """Make an instance."""
        return Instance(self, context)


class Clip:
    """A clip of an instance: what is connected to it."""

    def __init__(self, instance: Instance, described: Described) -> None:
        self.instance, self.name = instance, described.name
        self.props = Properties(properties.CLIP, OfxPropType=["OfxTypeClip"], OfxPropName=[described.name])
        self.held: Held | None = None
        self.number = instance.plugin.host.handle(self)
        self.props_number = instance.plugin.host.handle(self.props)

    def connect(self, held: Held | None) -> None:
        """Connect a picture, or nothing."""
        self.held = held
        alpha = held.layout.premultiplication if held else "OfxImageOpaque"
        depth = held.layout.depth if held else "OfxBitDepthNone"
        self.props.values |= {
            "OfxImageClipPropConnected": [int(held is not None)],
            "OfxImageEffectPropPreMultiplication": [alpha],
            "OfxImageEffectPropPixelDepth": [depth],
        }


class ParamValue:
    """A parameter of an instance: ``value`` is a number, a text, three numbers, or a function of the time."""

    def __init__(self, described: Described) -> None:
        self.name, self.kind = described.name, described.kind
        values = described.props.values.get("OfxParamPropDefault", [])
        self.value: Any = list(values) if self.kind == "OfxParamTypeRGB" else (values[0] if values else None)
        self.strings: list[Any] = []

    def at(self, time: float) -> Any:
        """Return the value at a time."""
        return self.value(time) if callable(self.value) else self.value


class Instance:
    """An instance of a plug-in, with clips and parameters."""

    def __init__(self, plugin: Plugin, context: str) -> None:
        self.plugin, host, described = plugin, plugin.host, plugin.contexts[context]
        self.scale = (1.0, 1.0)
        self.props = Properties(
            properties.INSTANCE, OfxPropType=["OfxTypeImageEffectInstance"], OfxImageEffectPropContext=[context]
        )
        self.clips = {name: Clip(self, each) for name, each in described.clips.items()}
        self.params = {name: ParamValue(each) for name, each in described.params.items()}
        self.param_numbers = {name: host.handle(each) for name, each in self.params.items()}
        self.number = host.handle(self)
        self.props_number = host.handle(self.props)
        self.status = plugin.call("OfxActionCreateInstance", self.number)

    def set(self, **values: Any) -> None:
        """Set parameters."""
        for name, value in values.items():
            self.params[name].value = value

    def project(self, width: float, height: float, x: float = 0, y: float = 0) -> None:
        """Say which format the project has."""
        self.props.values |= {
            "OfxImageEffectPropProjectSize": [float(width), float(height)],
            "OfxImageEffectPropProjectOffset": [float(x), float(y)],
        }

    @property
    def message(self) -> tuple[str, str] | None:
        """Return the message that stands on the instance: its kind and text."""
        return self.plugin.host.persistent.get(self.number)

    def render(
        self,
        *,
        window: tuple[int, int, int, int] | None = None,
        time: float = 1.0,
        scale: float = 1.0,
        expect: int | None = OK,
    ) -> np.ndarray[Any, Any]:
        """Render into the picture that is connected to Output, and return its pixels, the highest row first.

        ``expect`` is the status that the action has to return; None: any.
        """
        host, output = self.plugin.host, self.clips["Output"].held
        assert output is not None
        window = window or output.bounds
        self.scale = (scale, scale)
        output.before = output.memory.copy()
        arguments = Properties(
            properties.RENDER_IN,
            OfxPropTime=[float(time)],
            OfxImageEffectPropFieldToRender=["OfxFieldNone"],
            OfxImageEffectPropRenderWindow=list(window),
            OfxImageEffectPropRenderScale=[scale, scale],
        )
        self.last = self.plugin.call("OfxImageEffectActionRender", self.number, arguments)
        if expect is not None and self.last != expect:
            host.fault(f"render returned {self.last}, expected {expect}: {self.message} {host.messages[-1:]}")
        if output.touched_outside(window):
            host.fault(f"render wrote outside of {window}")
        for name, clip in self.clips.items():
            if name != "Output" and clip.held is not None and not np.array_equal(clip.held.memory, clip.held.before):
                host.fault(f"render wrote into {name}")
        return output.pixels

    def ask(self, action: str, given: Properties | None, wanted: Properties) -> tuple[int, dict[str, list[Any]]]:
        """Call an action that answers with properties; return its status and these."""
        status = self.plugin.call(action, self.number, given, wanted)
        return status, wanted.values

    def destroy(self) -> None:
        """Destroy the instance; no handle of it may be used any more."""
        host = self.plugin.host
        self.plugin.call("OfxActionDestroyInstance", self.number)
        if self.props.get("OfxPropInstanceData"):
            host.fault("OfxPropInstanceData still points somewhere after OfxActionDestroyInstance")
        numbers = [self.number, self.props_number, *self.param_numbers.values()]
        numbers += [number for clip in self.clips.values() for number in (clip.number, clip.props_number)]
        for number in numbers:
            host.drop(number)
