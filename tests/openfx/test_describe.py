"""What the plug-in tells a host: effects, clips, parameters; a host that lacks something."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.nodes import catalogue
from tests.openfx import properties
from tests.openfx.conftest import instance_of, picture
from tests.openfx.host import DEFAULT, FILTER, GENERAL, MISSING, OK, Descriptor, Host, Properties
from tests.openfx.images import Held, Layout

ROOT = Path(__file__).resolve().parents[2]


def test_every_shipped_graph_and_every_graph_of_ones_own_is_an_effect(host):
    wanted = {f"org.flowabs.{name}" for name in shipped()} | {"org.flowabs.user.panel", "org.flowabs.user.soft"}
    assert {plugin.identifier for plugin in host.plugins} == wanted
    assert all(plugin.status == OK and set(plugin.contexts) == {FILTER, GENERAL} for plugin in host.plugins)


def test_the_descriptor_says_what_the_effect_can_do(host):
    props = host.plugin("abstraction").descriptor.props
    assert props.get("OfxPropLabel") == "Flowabs Abstraction"
    assert props.get("OfxImageEffectPluginPropGrouping") == "Flowabs"
    assert props.values["OfxImageEffectPropSupportedPixelDepths"] == ["OfxBitDepthFloat", "OfxBitDepthHalf"]
    assert props.get("OfxImageEffectPropSupportsTiles") == 0
    assert props.get("OfxImageEffectPluginRenderThreadSafety") == "OfxImageEffectRenderInstanceSafe"
    assert props.get("OfxImageEffectPropClipPreferencesSlaveParam") == "output"


@pytest.mark.parametrize("context", [FILTER, GENERAL])
def test_clips_are_source_output_mask_and_one_for_each_further_read(host, context):
    clips = host.plugin("panel").contexts[context].clips
    assert set(clips) == {"Source", "Output", "Mask", "other", "depth"}
    assert clips["Mask"].props.get("OfxImageClipPropIsMask") == 1
    assert [name for name, clip in clips.items() if clip.props.get("OfxImageClipPropOptional")] == [
        "other",
        "depth",
        "Mask",
    ]
    assert "OfxImageComponentAlpha" in clips["Mask"].props.values["OfxImageEffectPropSupportedComponents"]


def test_knobs_are_parameters_of_their_types(host):
    params = host.plugin("panel").contexts[FILTER].params
    types = {name: param.kind.removeprefix("OfxParamType") for name, param in params.items()}
    assert types == {
        "output": "Choice",
        "mix": "Double",
        "colorspace": "Choice",
        "colorspace_name": "String",
        "stops": "Double",
        "which": "Integer",
        "how": "Choice",
        "ink": "RGB",
        "adaptive": "Boolean",
        "turned": "String",
        "moving": "Double",
        "mix_knob": "Double",
        "group_A___B": "Group",
        "group_Choice": "Group",
    }


def test_a_parameter_has_the_knobs_range_label_hint_and_default(host):
    params = host.plugin("panel").contexts[FILTER].params
    stops, how = params["stops"].props, params["how"].props
    assert (stops.get("OfxParamPropMin"), stops.get("OfxParamPropMax")) == (-8, 8)
    assert (stops.get("OfxParamPropDisplayMin"), stops.get("OfxParamPropDisplayMax")) == (-8, 8)
    assert stops.get("OfxPropLabel") == "Stops (stops)"
    assert stops.get("OfxParamPropHint") == "Light."
    assert stops.get("OfxParamPropParent") == "group_A___B"
    assert how.values["OfxParamPropChoiceOption"] == ["Plus", "Multiply", "Over"]
    assert how.get("OfxPropLabel") == "How it is merged"
    assert params["ink"].props.values["OfxParamPropDefault"] == [0.0, 0.25, 0.5]
    assert params["group_A___B"].props.get("OfxPropLabel") == "A & B"
    assert params["turned"].props.get("OfxParamPropAnimates") == 0  # this host cannot animate texts
    assert stops.get("OfxParamPropAnimates") == 1


def test_a_knob_without_a_range_has_the_slider_of_what_it_drives(host):
    low, high = catalogue()["exposure"].all_params["stops"].soft
    props = host.plugin("panel").contexts[FILTER].params["moving"].props
    assert (props.get("OfxParamPropDisplayMin"), props.get("OfxParamPropDisplayMax")) == (low, high)
    assert props.get("OfxParamPropMin") is None


def test_clip_preferences_follow_the_source_and_the_output(host):
    def wanted(output, alpha):
        instance = instance_of(host, "panel", picture(), layout=Layout(premultiplication=alpha))
        instance.set(output=output)
        out = Properties(properties.preferences_out(instance.clips))
        status, found = instance.ask("OfxImageEffectActionGetClipPreferences", None, out)
        instance.destroy()
        assert status == OK
        assert found["OfxImageEffectFrameVarying"] == [1]  # a knob of it moves
        return found["OfxImageEffectPropPreMultiplication"][0]

    assert wanted(0, "OfxImageOpaque") == "OfxImageOpaque"
    assert wanted(1, "OfxImageOpaque") == "OfxImageAlphaPremultiplied"
    assert wanted(1, "OfxImageAlphaUnPremultiplied") == "OfxImageAlphaUnPremultiplied"


def test_the_whole_frame_is_wanted_of_every_picture(host):
    instance = instance_of(host, "panel", picture())
    instance.clips["depth"].connect(Held(picture(4, 4)))
    out = Properties(properties.interest_out(instance.clips))
    asked = Properties(properties.REGION_IN, OfxPropTime=[1.0], OfxImageEffectPropRegionOfInterest=[2.0, 2.0, 3.0, 3.0])
    status, found = instance.ask("OfxImageEffectActionGetRegionsOfInterest", asked, out)
    assert (status, found) == (
        OK,
        {"OfxImageClipPropRoI_Source": [0, 0, 16, 12], "OfxImageClipPropRoI_depth": [0, 0, 4, 4]},
    )
    asked = Properties(properties.REGION_IN, OfxPropTime=[1.0])
    out = Properties(properties.DEFINITION_OUT)
    status, found = instance.ask("OfxImageEffectActionGetRegionOfDefinition", asked, out)
    assert (status, found) == (OK, {"OfxImageEffectPropRegionOfDefinition": [0, 0, 16, 12]})
    instance.destroy()


def test_at_mix_0_the_source_is_the_result(host):
    instance = instance_of(host, "panel", picture())
    for mix, expected in ((0.0, OK), (-1.0, OK), (0.5, DEFAULT)):
        instance.set(mix=mix)
        asked = Properties(properties.RENDER_IN, OfxPropTime=[3.0])
        status, found = instance.ask("OfxImageEffectActionIsIdentity", asked, Properties(properties.IDENTITY_OUT))
        assert status == expected
        assert found == ({"OfxPropName": ["Source"], "OfxPropTime": [3.0]} if expected == OK else {})
    instance.destroy()


def test_describing_starts_no_process(library):
    program = (
        "import os, sys; from pathlib import Path; from tests.openfx.host import Host\n"
        f"host = Host(Path({str(library)!r})); host.close()\n"
        "assert host.faults == [], host.faults\n"
        "try: print(os.waitpid(-1, os.WNOHANG))\n"
        "except ChildProcessError: print('none')\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout == "none\n"


@pytest.mark.parametrize("suite", ["OfxPropertySuite", "OfxImageEffectSuite", "OfxParameterSuite"])
def test_a_host_without_a_needed_suite_is_told_so(elsewhere, suite, capfd):
    host = Host(elsewhere(), without=[suite])
    assert {plugin.status for plugin in host.plugins} == {MISSING}
    assert f"this host has no {suite}" in capfd.readouterr().err
    assert host.faults == []


def test_a_host_of_8_bits_alone_is_refused_with_the_reason(elsewhere):
    host = Host(elsewhere(), depths=["OfxBitDepthByte", "OfxBitDepthShort"])
    assert {plugin.status for plugin in host.plugins} == {MISSING}
    assert "pixels of 8 or 16 bits only" in host.messages[0][1]
    host.close()
    assert host.faults == []


def test_actions_in_wrong_orders_do_no_harm(elsewhere):
    host = Host(elsewhere())
    plugin = host.plugin("panel")
    stranger = host.handle(Descriptor())  # an effect that was never made an instance
    asked = Properties(properties.RENDER_IN, OfxPropTime=[1.0])
    plugin.call("OfxImageEffectActionIsIdentity", stranger, asked, Properties(properties.IDENTITY_OUT))
    plugin.call("OfxImageEffectActionRender", stranger, asked)
    plugin.call("OfxActionDestroyInstance", stranger)
    assert plugin.call("OfxActionNobodyKnows", stranger) == DEFAULT
    # asking a descriptor for an instance's data is what shows it is none: the only faults there may be
    assert all("no property OfxPropInstanceData" in fault for fault in host.faults)
    host.faults.clear()
    instance = plugin.instance()
    instance.destroy()
    plugin.unload()
    assert plugin.call("OfxActionDescribe", Descriptor()) in (OK, 1)
    host.close()
    host.close()
    assert plugin.call("OfxActionDescribe", Descriptor()) == 1  # nothing is loaded any more
    assert host.faults == []


@pytest.mark.parametrize(
    "content", [None, "", "{", '{"format": "other"}', '{"format": "flowabs.openfx/1", "effects": 3}']
)
def test_a_bundle_without_good_effects_has_no_plugin_and_says_why(elsewhere, content, capfd):
    library = elsewhere()
    file = library.parents[1] / "Resources" / "effects.json"
    file.unlink() if content is None else file.write_text(content)
    assert Host(library).plugins == []
    if content != '{"format": "flowabs.openfx/1", "effects": 3}':
        assert "effects.json" in capfd.readouterr().err


def test_text_of_any_script_comes_through(elsewhere):
    library = elsewhere()
    file = library.parents[1] / "Resources" / "effects.json"
    document = json.loads(file.read_text())
    document["effects"][0]["label"] = 'Flußbild "線" \\ 𝔽 \t'
    file.write_text(json.dumps(document))  # all but ASCII is escaped
    host = Host(library)
    assert host.plugins[0].descriptor.props.get("OfxPropLabel") == 'Flußbild "線" \\ 𝔽 \t'
    host.close()
    assert host.faults == []
