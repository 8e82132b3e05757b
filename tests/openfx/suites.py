"""The suites of the test host: functions that a plug-in calls, each of which checks what it is given."""

from __future__ import annotations

import ctypes as c
from typing import Any

from tests.openfx import properties
from tests.openfx.host import (
    _MANY,
    _TYPES,
    BAD_HANDLE,
    BAD_INDEX,
    DEFAULT,
    EXISTS,
    FAILED,
    NO,
    OK,
    UNKNOWN,
    UNSUPPORTED,
    VALUE,
    Clip,
    Described,
    Descriptor,
    Host,
    Instance,
    ParamValue,
    Properties,
)

_P, _V, _I, _D, _S = c.POINTER, c.c_void_p, c.c_int, c.c_double, c.c_char_p

#: The actions in which a plug-in may take images.
_WORKING = ("OfxImageEffectActionRender",)
_DESCRIBING = ("OfxActionDescribe", "OfxImageEffectActionDescribeInContext")


def _no(host: Host, name: str) -> int:
    """Return a function that nobody should call here."""

    def refused() -> int:
        host.fault(f"{name} was called")
        return UNSUPPORTED

    return host._function(_I)(refused)


# ---------------------------------------------------------------------- properties


def _checked(host: Host, call: str, number: int, name: bytes, kind: str, index: int, setting: bool) -> Any:
    """Return a property set, or a status where a call is not allowed."""
    found = host.of(number, Properties, call)
    if found is None:
        return BAD_HANDLE
    text = name.decode()
    known = found.known.get(text)
    if known is None:
        host.fault(f"{call}: no property {text}")
        return UNKNOWN
    if known.type != kind:
        host.fault(f"{call}: {text} is of type {known.type}")
        return VALUE
    if setting and not known.settable:
        host.fault(f"{call}: {text} may not be set")
        return VALUE
    if index < 0 or (known.count and index >= known.count):
        host.fault(f"{call}: {text} has no index {index}")
        return BAD_INDEX
    return found


def _put(host: Host, call: str, found: Properties, name: str, index: int, value: Any) -> int:
    values = found.values.setdefault(name, [])
    if index > len(values):
        host.fault(f"{call}: {name} is set at {index}, but has {len(values)} values")
    values.extend([None] * (index + 1 - len(values)))
    if isinstance(value, bytes):
        value = value.decode("utf-8")  # a fault of the host's callback where it is none
    values[index] = value
    return OK


def _write(found: Properties, name: str, index: int, out: Any, kind: str) -> None:
    value = found.values[name][index]
    if kind == "string":
        kept = found.strings.setdefault((name, index, value), c.create_string_buffer(value.encode()))
        c.cast(out, _P(_V))[0] = c.addressof(kept)
    else:
        out[0] = value


def property_suite(host: Host) -> list[int]:
    """Return the functions of OfxPropertySuiteV1."""

    def setter(kind: str) -> int:
        def set_one(number: int, name: bytes, index: int, value: Any) -> int:
            found = _checked(host, f"propSet{kind}", number, name, kind, index, True)
            return found if isinstance(found, int) else _put(host, f"propSet{kind}", found, name.decode(), index, value)

        return host._function(_I, _V, _S, _I, _TYPES[kind])(set_one)

    def setter_of_many(kind: str) -> int:
        def set_many(number: int, name: bytes, count: int, values: Any) -> int:
            found = _checked(host, f"propSet{kind}N", number, name, kind, count - 1, True)
            if isinstance(found, int):
                return found
            if found.known[name.decode()].count not in (0, count):
                host.fault(f"propSet{kind}N: {name.decode()} gets {count} values")
            for index in range(count):
                _put(host, f"propSet{kind}N", found, name.decode(), index, values[index])
            return OK

        return host._function(_I, _V, _S, _I, _P(_TYPES[kind]))(set_many)

    def getter(kind: str, many: bool) -> int:
        def get(number: int, name: bytes, index: int, out: Any) -> int:
            call, text = f"propGet{kind}{'N' if many else ''}", name.decode()
            found = _checked(host, call, number, name, kind, index - 1 if many else index, False)
            if isinstance(found, int):
                return found
            indices = range(index) if many else [index]
            if len(found.values.get(text, [])) <= indices[-1]:
                return UNKNOWN  # a host need not have every property
            for place, each in enumerate(indices):
                _write(found, text, each, c.pointer(out[place]) if many else out, kind) if kind == "string" else (
                    out.__setitem__(place, found.values[text][each])
                )
            return OK

        return host._function(_I, _V, _S, _I, _P(_TYPES[kind]))(get)

    def dimension(number: int, name: bytes, out: Any) -> int:
        found = host.of(number, Properties, "propGetDimension")
        if found is None or name.decode() not in found.known:
            host.fault(f"propGetDimension: no property {name.decode()}")
            return UNKNOWN
        out[0] = len(found.values.get(name.decode(), []))
        return OK

    return [
        *(setter(kind) for kind in _MANY),
        *(setter_of_many(kind) for kind in _MANY),
        *(getter(kind, False) for kind in _MANY),
        *(getter(kind, True) for kind in _MANY),
        _no(host, "propReset"),
        host._function(_I, _V, _S, _P(_I))(dimension),
    ]


# ---------------------------------------------------------------------- effects and clips


def effect_suite(host: Host) -> list[int]:
    """Return the functions of OfxImageEffectSuiteV1."""
    numbers: dict[int, tuple[Any, int]] = {}

    def number_of(thing: Any) -> int:
        """Return the one handle of an object's properties."""
        if id(thing) not in numbers:
            numbers[id(thing)] = thing, host.handle(thing)
        return numbers[id(thing)][1]

    def get_property_set(effect: int, out: Any) -> int:
        found = host._objects.get(effect)
        if isinstance(found, Instance):
            out[0] = found.props_number
        elif isinstance(found, Descriptor):
            out[0] = number_of(found.props)
        else:
            host.fault(f"getPropertySet: {effect} is no effect")
            return BAD_HANDLE
        return OK

    def get_param_set(effect: int, out: Any) -> int:
        if not isinstance(host._objects.get(effect), Instance | Descriptor):
            host.fault(f"getParamSet: {effect} is no effect")
            return BAD_HANDLE
        out[0] = effect  # a parameter set has the handle of its effect here
        return OK

    def clip_define(effect: int, name: bytes, out: Any) -> int:
        found = host.of(effect, Descriptor, "clipDefine")
        if host.action != "OfxImageEffectActionDescribeInContext":
            host.fault("clipDefine outside of DescribeInContext")
        if found is None:
            return BAD_HANDLE
        if name.decode() in found.clips:
            host.fault(f"clipDefine: {name.decode()} twice")
            return EXISTS
        props = Properties(properties.CLIP_DESCRIPTOR, OfxPropName=[name.decode()])
        found.clips[name.decode()] = Described(name.decode(), "clip", props)
        out[0] = host.handle(props)
        return OK

    def clip_get_handle(effect: int, name: bytes, clip: Any, props: Any) -> int:
        found = host.of(effect, Instance, "clipGetHandle")
        if host.action in _DESCRIBING:
            host.fault("clipGetHandle while describing")
        if found is None:
            return BAD_HANDLE
        if name.decode() not in found.clips:
            host.fault(f"clipGetHandle: no clip {name.decode()}")
            return UNKNOWN
        clip[0] = found.clips[name.decode()].number
        if props:
            props[0] = found.clips[name.decode()].props_number
        return OK

    def clip_get_property_set(clip: int, out: Any) -> int:
        found = host.of(clip, Clip, "clipGetPropertySet")
        if found is None:
            return BAD_HANDLE
        out[0] = found.props_number
        return OK

    def clip_get_image(clip: int, time: float, region: Any, out: Any) -> int:
        found = host.of(clip, Clip, "clipGetImage")
        if host.action not in _WORKING:
            host.fault("clipGetImage outside of a render")
        if found is None:
            return BAD_HANDLE
        if found.held is None:
            return FAILED
        values = found.held.properties(found.instance.scale)
        values |= getattr(found, "lies", {})
        image = host.handle(Properties(properties.IMAGE, **{name: each for name, each in values.items() if each}))
        host._images.add(image)
        host.taken += 1
        out[0] = image
        return OK

    def clip_release_image(image: int) -> int:
        if image not in host._images:
            host.fault(f"clipReleaseImage: {image} is no image that is out")
            return BAD_HANDLE
        host._images.discard(image)
        host.drop(image)
        host.given_back += 1
        return OK

    def clip_get_definition(clip: int, time: float, out: Any) -> int:
        found = host.of(clip, Clip, "clipGetRegionOfDefinition")
        if found is None:
            return BAD_HANDLE
        if found.held is None:
            return FAILED
        for index, value in enumerate(found.held.layout.whole or found.held.bounds):
            out[index] = value / found.instance.scale[0]
        return OK

    def abort(effect: int) -> int:
        host.of(effect, Instance, "abort")
        return int(host.aborts())

    return [
        host._function(_I, _V, _P(_V))(get_property_set),
        host._function(_I, _V, _P(_V))(get_param_set),
        host._function(_I, _V, _S, _P(_V))(clip_define),
        host._function(_I, _V, _S, _P(_V), _P(_V))(clip_get_handle),
        host._function(_I, _V, _P(_V))(clip_get_property_set),
        host._function(_I, _V, _D, _V, _P(_V))(clip_get_image),
        host._function(_I, _V)(clip_release_image),
        host._function(_I, _V, _D, _P(_D))(clip_get_definition),
        host._function(_I, _V)(abort),
        *(_no(host, f"imageMemory{name}") for name in ("Alloc", "Free", "Lock", "Unlock")),
    ]


# ---------------------------------------------------------------------- parameters


def parameter_suite(host: Host) -> list[int]:
    """Return the functions of OfxParameterSuiteV1."""

    def define(effect: int, kind: bytes, name: bytes, out: Any) -> int:
        found, text = host.of(effect, Descriptor, "paramDefine"), name.decode("ascii")
        if host.action not in _DESCRIBING:
            host.fault("paramDefine outside of the describe actions")
        if found is None:
            return BAD_HANDLE
        if text in found.params:
            host.fault(f"paramDefine: {text} twice")
            return EXISTS
        if kind.decode() not in properties.PARAMS:
            host.fault(f"paramDefine: no type {kind.decode()}")
            return UNKNOWN
        props = Properties(properties.PARAMS[kind.decode()], OfxPropName=[text], OfxParamPropType=[kind.decode()])
        found.params[text] = Described(text, kind.decode(), props)
        if out:
            out[0] = host.handle(props)
        return OK

    def get_handle(effect: int, name: bytes, param: Any, props: Any) -> int:
        found = host.of(effect, Instance, "paramGetHandle")
        if found is None:
            return BAD_HANDLE
        if name.decode() not in found.params:
            host.fault(f"paramGetHandle: no parameter {name.decode()}")
            return UNKNOWN
        if props:
            host.fault("paramGetHandle: this host has no properties of parameters here")
        param[0] = found.param_numbers[name.decode()]
        return OK

    def get_value(param: int, time: float, first: int, second: int, third: int) -> int:
        found = host.of(param, ParamValue, "paramGetValueAtTime")
        if found is None:
            return BAD_HANDLE
        value = found.at(time)
        if found.kind == "OfxParamTypeDouble":
            c.cast(first, _P(_D))[0] = value
        elif found.kind == "OfxParamTypeRGB":
            for place, one in zip((first, second, third), value, strict=True):
                c.cast(place, _P(_D))[0] = one
        elif found.kind == "OfxParamTypeString":
            found.strings.append(c.create_string_buffer(value.encode()))
            c.cast(first, _P(_V))[0] = c.addressof(found.strings[-1])
        else:
            c.cast(first, _P(_I))[0] = int(value)
        return OK

    names = (
        *("paramSetGetPropertySet", "paramGetPropertySet", "paramGetValue"),
        *("paramGetDerivative", "paramGetIntegral", "paramSetValue", "paramSetValueAtTime", "paramGetNumKeys"),
        *("paramGetKeyTime", "paramGetKeyIndex", "paramDeleteKey", "paramDeleteAllKeys", "paramCopy"),
        *("paramEditBegin", "paramEditEnd"),
    )
    return [
        host._function(_I, _V, _S, _S, _P(_V))(define),
        host._function(_I, _V, _S, _P(_V), _P(_V))(get_handle),
        *(_no(host, name) for name in names[:3]),
        host._function(_I, _V, _D, _V, _V, _V)(get_value),
        *(_no(host, name) for name in names[3:]),
    ]


# ---------------------------------------------------------------------- messages, progress


def message_suite(host: Host) -> list[int]:
    """Return the functions of OfxMessageSuiteV2, whose first is that of version 1."""

    def text_of(form: bytes, text: bytes | None) -> str:
        if form != b"%s":
            host.fault(f"a message is no format: {form!r}")
        return (text or b"").decode("utf-8")

    def message(effect: int | None, kind: bytes, name: bytes, form: bytes, text: bytes) -> int:
        host.messages.append((kind.decode(), text_of(form, text)))
        return OK

    def persistent(effect: int, kind: bytes, name: bytes, form: bytes, text: bytes) -> int:
        if host.of(effect, Instance, "setPersistentMessage") is None:
            return BAD_HANDLE
        host.persistent[effect] = kind.decode(), text_of(form, text)
        return OK

    def clear(effect: int) -> int:
        if host.of(effect, Instance, "clearPersistentMessage") is None:
            return BAD_HANDLE
        host.persistent.pop(effect, None)
        return OK

    return [
        host._function(_I, _V, _S, _S, _S, _S)(message),
        host._function(_I, _V, _S, _S, _S, _S)(persistent),
        host._function(_I, _V)(clear),
    ]


def progress_suite(host: Host) -> list[int]:
    """Return the functions of OfxProgressSuiteV1."""

    def start(effect: int, label: bytes) -> int:
        host.of(effect, Instance, "progressStart")
        host.progress_open += 1
        if host.progress_open != 1:
            host.fault("progressStart while a bar is shown")
        return OK

    def update(effect: int, done: float) -> int:
        if host.progress_open != 1 or not 0 <= done <= 1:
            host.fault(f"progressUpdate: {done} with {host.progress_open} bars")
        host.progress.append(done)
        return NO if host.cancel_bar else OK

    def end(effect: int) -> int:
        host.progress_open -= 1
        if host.progress_open:
            host.fault("progressEnd without a bar")
        return OK

    return [
        host._function(_I, _V, _S)(start),
        host._function(_I, _V, _D)(update),
        host._function(_I, _V)(end),
    ]


__all__ = ["DEFAULT", "effect_suite", "message_suite", "parameter_suite", "progress_suite", "property_suite"]
