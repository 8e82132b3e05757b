"""The properties of OpenFX 1.4 by the objects that have them: type, number of values, whether a plug-in may set them.

Written from the reference. The test host refuses, and notes as a fault, whatever is not in these tables.
"""

from __future__ import annotations

from typing import Any, NamedTuple


class Property(NamedTuple):
    """What a property holds: "int", "double", "string" or "pointer"; how many values, 0 for any; who may set it."""

    type: str
    count: int = 1
    settable: bool = False


def _read(**named: str) -> dict[str, Property]:
    """Return properties that a plug-in may only read: "string", or "int 4"."""
    return {name: _property(what, False) for name, what in named.items()}


def _set(**named: str) -> dict[str, Property]:
    """Return properties that a plug-in may set as well."""
    return {name: _property(what, True) for name, what in named.items()}


def _property(what: str, settable: bool) -> Property:
    kind, _, count = what.partition(" ")
    return Property(kind, int(count or 1), settable)


_LABELS = _set(OfxPropLabel="string", OfxPropShortLabel="string", OfxPropLongLabel="string")
_ANYTHING = _read(OfxPropType="string", OfxPropName="string")

HOST = _ANYTHING | _read(
    OfxPropLabel="string",
    OfxPropVersion="int 0",
    OfxPropVersionLabel="string",
    OfxPropAPIVersion="int 0",
    OfxImageEffectHostPropIsBackground="int",
    OfxImageEffectPropSupportsOverlays="int",
    OfxImageEffectPropSupportsMultiResolution="int",
    OfxImageEffectPropSupportsTiles="int",
    OfxImageEffectPropTemporalClipAccess="int",
    OfxImageEffectPropSupportedComponents="string 0",
    OfxImageEffectPropSupportedContexts="string 0",
    OfxImageEffectPropSupportedPixelDepths="string 0",
    OfxImageEffectPropMultipleClipDepths="int",
    OfxImageEffectPropSupportsMultipleClipPARs="int",
    OfxImageEffectPropSetableFrameRate="int",
    OfxImageEffectPropSetableFielding="int",
    OfxParamHostPropSupportsCustomInteract="int",
    OfxParamHostPropSupportsStringAnimation="int",
    OfxParamHostPropSupportsChoiceAnimation="int",
    OfxParamHostPropSupportsBooleanAnimation="int",
    OfxParamHostPropSupportsCustomAnimation="int",
    OfxParamHostPropMaxParameters="int",
    OfxParamHostPropMaxPages="int",
    OfxParamHostPropPageRowColumnCount="int 2",
)

DESCRIPTOR = (
    _LABELS
    | _read(OfxPropType="string", OfxPluginPropFilePath="string")
    | _set(
        OfxPropVersion="int 0",
        OfxPropVersionLabel="string",
        OfxPropPluginDescription="string",
        OfxImageEffectPropSupportedContexts="string 0",
        OfxImageEffectPropSupportedPixelDepths="string 0",
        OfxImageEffectPluginPropGrouping="string",
        OfxImageEffectPluginPropSingleInstance="int",
        OfxImageEffectPluginRenderThreadSafety="string",
        OfxImageEffectPluginPropHostFrameThreading="int",
        OfxImageEffectPluginPropOverlayInteractV1="pointer",
        OfxImageEffectPropSupportsMultiResolution="int",
        OfxImageEffectPropSupportsTiles="int",
        OfxImageEffectPropTemporalClipAccess="int",
        OfxImageEffectPluginPropFieldRenderTwiceAlways="int",
        OfxImageEffectPropMultipleClipDepths="int",
        OfxImageEffectPropSupportsMultipleClipPARs="int",
        OfxImageEffectPropClipPreferencesSlaveParam="string 0",
    )
)

INSTANCE = _read(
    OfxPropType="string",
    OfxPropLabel="string",
    OfxImageEffectPropContext="string",
    OfxImageEffectPropProjectSize="double 2",
    OfxImageEffectPropProjectOffset="double 2",
    OfxImageEffectPropProjectExtent="double 2",
    OfxImageEffectPropPixelAspectRatio="double",
    OfxImageEffectInstancePropEffectDuration="double",
    OfxImageEffectPropFrameRate="double",
    OfxPropIsInteractive="int",
    OfxImageEffectPropPluginHandle="pointer",
) | _set(
    OfxPropInstanceData="pointer",
    OfxImageEffectInstancePropSequentialRender="int",
    OfxImageEffectPropSupportsTiles="int",
)

CLIP_DESCRIPTOR = (
    _ANYTHING
    | _LABELS
    | _set(
        OfxImageEffectPropSupportedComponents="string 0",
        OfxImageEffectPropTemporalClipAccess="int",
        OfxImageClipPropOptional="int",
        OfxImageClipPropFieldExtraction="string",
        OfxImageClipPropIsMask="int",
        OfxImageEffectPropSupportsTiles="int",
    )
)

CLIP = _ANYTHING | _read(
    OfxPropLabel="string",
    OfxPropShortLabel="string",
    OfxPropLongLabel="string",
    OfxImageEffectPropSupportedComponents="string 0",
    OfxImageEffectPropTemporalClipAccess="int",
    OfxImageClipPropOptional="int",
    OfxImageClipPropFieldExtraction="string",
    OfxImageClipPropIsMask="int",
    OfxImageEffectPropSupportsTiles="int",
    OfxImageEffectPropPixelDepth="string",
    OfxImageEffectPropComponents="string",
    OfxImageClipPropUnmappedPixelDepth="string",
    OfxImageClipPropUnmappedComponents="string",
    OfxImageEffectPropPreMultiplication="string",
    OfxImagePropPixelAspectRatio="double",
    OfxImageEffectPropFrameRate="double",
    OfxImageEffectPropFrameRange="double 2",
    OfxImageClipPropFieldOrder="string",
    OfxImageClipPropConnected="int",
    OfxImageEffectPropUnmappedFrameRange="double 2",
    OfxImageEffectPropUnmappedFrameRate="double",
    OfxImageClipPropContinuousSamples="int",
)

IMAGE = _read(
    OfxPropType="string",
    OfxImageEffectPropPixelDepth="string",
    OfxImageEffectPropComponents="string",
    OfxImageEffectPropPreMultiplication="string",
    OfxImageEffectPropRenderScale="double 2",
    OfxImagePropPixelAspectRatio="double",
    OfxImagePropData="pointer",
    OfxImagePropBounds="int 4",
    OfxImagePropRegionOfDefinition="int 4",
    OfxImagePropRowBytes="int",
    OfxImagePropField="string",
    OfxImagePropUniqueIdentifier="string",
)

_PARAM = (
    _ANYTHING
    | _LABELS
    | _read(OfxParamPropType="string")
    | _set(
        OfxParamPropSecret="int",
        OfxParamPropCanUndo="int",
        OfxParamPropHint="string",
        OfxParamPropScriptName="string",
        OfxParamPropParent="string",
        OfxParamPropEnabled="int",
        OfxParamPropDataPtr="pointer",
    )
)
_VALUE = _set(
    OfxParamPropAnimates="int",
    OfxParamPropPersistant="int",
    OfxParamPropEvaluateOnChange="int",
    OfxParamPropPluginMayWrite="int",
    OfxParamPropCacheInvalidation="string",
)


def _number(kind: str) -> dict[str, Property]:
    ends = ("Min", "Max", "DisplayMin", "DisplayMax", "Default")
    return {f"OfxParamProp{end}": Property(kind, 1, True) for end in ends}


#: The properties of a parameter by its type.
PARAMS: dict[str, dict[str, Property]] = {
    "OfxParamTypeDouble": _PARAM
    | _VALUE
    | _number("double")
    | _set(OfxParamPropIncrement="double", OfxParamPropDigits="int", OfxParamPropDoubleType="string"),
    "OfxParamTypeInteger": _PARAM | _VALUE | _number("int"),
    "OfxParamTypeBoolean": _PARAM | _VALUE | _set(OfxParamPropDefault="int"),
    "OfxParamTypeChoice": _PARAM | _VALUE | _set(OfxParamPropDefault="int", OfxParamPropChoiceOption="string 0"),
    "OfxParamTypeRGB": _PARAM | _VALUE | _set(OfxParamPropDefault="double 3"),
    "OfxParamTypeRGBA": _PARAM | _VALUE | _set(OfxParamPropDefault="double 4"),
    "OfxParamTypeString": _PARAM
    | _VALUE
    | _set(OfxParamPropDefault="string", OfxParamPropStringMode="string", OfxParamPropStringFilePathExists="int"),
    "OfxParamTypeGroup": _PARAM,
}

RENDER_IN = _read(
    OfxPropTime="double",
    OfxImageEffectPropFieldToRender="string",
    OfxImageEffectPropRenderWindow="int 4",
    OfxImageEffectPropRenderScale="double 2",
    OfxImageEffectPropSequentialRenderStatus="int",
    OfxImageEffectPropInteractiveRenderStatus="int",
)
CONTEXT_IN = _read(OfxImageEffectPropContext="string")
REGION_IN = _read(
    OfxPropTime="double", OfxImageEffectPropRenderScale="double 2", OfxImageEffectPropRegionOfInterest="double 4"
)
DEFINITION_OUT = _set(OfxImageEffectPropRegionOfDefinition="double 4")
IDENTITY_OUT = _set(OfxPropName="string", OfxPropTime="double")


def interest_out(clips: Any) -> dict[str, Property]:
    """Return what GetRegionsOfInterest may set for these clips."""
    return {f"OfxImageClipPropRoI_{clip}": Property("double", 4, True) for clip in clips}


def preferences_out(clips: Any) -> dict[str, Property]:
    """Return what GetClipPreferences may set for these clips."""
    each = {}
    for clip in clips:
        each[f"OfxImageClipPropComponents_{clip}"] = Property("string", 1, True)
        each[f"OfxImageClipPropDepth_{clip}"] = Property("string", 1, True)
        each[f"OfxImageClipPropPAR_{clip}"] = Property("double", 1, True)
    return each | _set(
        OfxImageEffectPropFrameRate="double",
        OfxImageClipPropFieldOrder="string",
        OfxImageEffectPropPreMultiplication="string",
        OfxImageClipPropContinuousSamples="int",
        OfxImageEffectFrameVarying="int",
    )
