"""Write the page of ``docs/compare``, in Markdown, around the measured numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

Numbers = Mapping[str, Mapping[str, Mapping[str, float]]]

GOAL_FLICKER = 0.03
GOAL_JAG = 5.0

HEAD = """\
# Side by side

What flowabs makes of five pictures, beside what the paper compares itself with and what OpenCV has. All of it again
(it needs OpenCV and SciPy, which the extra `test` installs):

<!-- not run: minutes of measuring -->
```sh
python -m tools.gallery.compare
```

[Pictures](../pictures/README.md) are shown, and measured, at the 540 lines that the shipped graphs are meant for:
`raccoon` is made smaller, the others larger. Every number on this page is in [numbers.json](numbers.json).
"""

LINES = """\
## Lines

**Flicker** is the mean |difference| of two drawings of one frame, over their mean ink: the frame under two draws of
noise of sigma 2 of 255, display values. **Jag** is how many degrees, on average, the edge of a stroke turns from its
direction round about. [measures.py](../../tools/gallery/measures.py) has the exact definitions.
"""

AFTER_LINES = """\
The goal for `lines` is a flicker of at most {flicker:g} and a jag of at most {jag:g}, as means of the five: it has
{found}. Fur is the hardest: the cat flickers most. At the
pictures' own sizes, where a stroke is as thin as half a pixel (the cat has 300 lines), it is {own}.

What the graph's values are worth, each changed alone, on these pictures (as shipped: flicker .027, jag 4.5, ink 9.6 %):

| change | flicker | jag | ink % | |
|---|---|---|---|---|
| no rolling guidance, `broad.sigma_s` 0 | .041 | 5.0 | 11.5 | fur, grass and wood become ink |
| two steps of it instead of one, `broad.iterations` 2 | .028 | 4.7 | 10.0 | takes longer |
| `lines.pre_blur` 1 instead of 1.7 | .033 | 5.0 | 10.6 | crisper, and less calm |
| `ink_shoulder.lift` 0 instead of 0.02 | .030 | 4.7 | 11.0 | more in dark faces and coats, and noise in near-black |
| no evidence, `lines.evidence` 0 | .026 | 4.8 | 9.8 | more specks |
| `lines.lone_lines` 0 instead of 5 | .025 | 4.5 | 9.4 | faint outlines and the far side of faces are left out |
| neither length nor taper, `strokes` off | .027 | 4.2 | 9.8 | more specks, blunt ends |
| `space` lab, `contrast` .55, `softness` 4, `color_weight` 1 | .028 | 3.9 | 7.5 | dark faces fade |
| `lines.smooth` 1.5 instead of 3.6 | .025 | 4.9 | 9.6 | |
| two passes of FBL before the lines instead of one | .026 | 4.5 | 9.3 | takes longer |
| one pass of lines instead of two | .028 | 3.4 | 5.1 | pencil instead of pen |
| softness 4 instead of 2.4 | .026 | 3.8 | 6.5 | paler lines |
| `lines.thin_lines` 0 instead of 4 | .026 | 4.5 | 9.6 | whiskers, cables and rims of light as two lines |
| `lines.color_weight` 0.5 instead of 1.55 | .024 | 4.5 | 8.4 | edges of equal lightness are left out |
| `soft_lines` 0 | .025 | 4.7 | 7.8 | a jaw, hair, a soft ground are left out |

Seen: isotropic DoG breaks into dots where FDoG draws a stroke, and its edges are stairs; soft, it is paler but still
no line. Canny's outlines have no weight, and its thresholds are relative to the frame's strongest edge: one HDR
highlight leaves the render empty. FDoG at the paper's values draws more, all of it black and white, and noise in the
dark with it; the monkey's head against the sky, an edge in colour alone, only `lines` draws whole. Ours leaves out
whiskers and most marks of the fur with its texture, and draws highlights on the ring as if they were edges.
"""

COLOR = """\
## Flat colour

Mean |difference| of two draws of the same noise, in display values of 255; the noise itself has 2.26.
"""

AFTER_COLOR = """\
Seen: mean shift's borders are ragged, and large regions change with the noise. The bilateral filter with levels is
near to `flat`, with more crumbs along its borders. Stylization darkens, loses the stripes of the box, and breaks faces
up. `abstraction` leaves soft shading soft, a sky as well as a face; `flat` has half of its steps there, and the knob
`bands` of both goes from one to the other.
"""

RESTORATION = """\
## Figs. 16 and 17 in numbers

PSNR against the clean picture, and edge error (0 is perfect, 1 is no edge at all), at the paper's parameters. The
flower is drawn by code: flat shapes with clean outlines, as in the paper. Photographs, at most 400x400 of each, have
texture that no smoothing brings back.

![Flower, noisy and as JPEG, restored](restoration.jpg)
"""

AFTER_RESTORATION = """\
The paper's `sigma_r` 10 is half the noise: the bilateral filter takes noise for edges and leaves it, where FBL, with
`r_e` 50, may average along the flow. The last column gives the bilateral filter the best of `sigma_r` 10, 20, 40, 80:
on noise it stays below FBL. As JPEG, neither gains much over what goes in. FBL straightens the stairs of a boundary,
but these are few pixels; ringing beside it stays, for `sigma_g` 0.3 hardly smooths across. There the bilateral filter
has the smaller edge error on the flower, and with another `sigma_r` the better PSNR too.
"""

TIME = """\
## Time

![Time against kernel radius](../gallery/fig23.svg)

Fig. 23 again: `python -m tools.gallery.speed --svg fig23.svg --json fig23.json`. {picture}, one thread,
{machine}. For ETF the radius is mu, for FDoG and FBL alpha = beta.
"""


def page(numbers: Mapping[str, Any], words: Mapping[str, str], times: Mapping[str, Any]) -> str:
    """Return the whole page, from ``numbers.json``, a description of each method, and ``fig23.json``."""
    pictures = list(next(iter(numbers["lines"].values())))
    ours = next(iter(numbers["lines"]))
    flicker, jag = (_mean(numbers["lines"][ours], key) for key in ("flicker", "jag"))
    small_flicker, small_jag = (_mean(numbers["own size"][ours], key) for key in ("flicker", "jag"))
    own = f"{small_flicker:.3f} and {small_jag:.1f}"
    found = f"{flicker:.3f} and {jag:.1f}"
    sheets = [f"![{Path(name).stem}]({Path(name).stem}.jpg)\n" for name in pictures]
    parts = [
        HEAD,
        *sheets,
        LINES,
        _lines_table(numbers["lines"], words, pictures),
        AFTER_LINES.format(flicker=GOAL_FLICKER, jag=GOAL_JAG, found=found, own=own),
        COLOR,
        _color_table(numbers["color"], words, pictures),
        AFTER_COLOR,
        RESTORATION,
        *(_restoration_table(figure, values) for figure, values in numbers["restoration"].items()),
        AFTER_RESTORATION,
        TIME.format(**times),
        _time_table(times),
    ]
    return "\n".join(parts)


def _lines_table(lines: Numbers, words: Mapping[str, str], pictures: Sequence[str]) -> str:
    rows = [["flicker / jag", *(Path(name).stem for name in pictures), "mean", "ink", ""]]
    for method, values in lines.items():
        each = [f"{values[name]['flicker']:.3f} / {values[name]['jag']:.1f}" for name in pictures]
        mean = f"**{_mean(values, 'flicker'):.3f} / {_mean(values, 'jag'):.1f}**"
        rows.append([method, *each, mean, f"{100 * _mean(values, 'ink'):.1f} %", words[method]])
    return _table(rows)


def _color_table(color: Numbers, words: Mapping[str, str], pictures: Sequence[str]) -> str:
    rows = [["", *(Path(name).stem for name in pictures), "mean", ""]]
    for method, values in color.items():
        each = [f"{values[name]['flicker']:.2f}" for name in pictures]
        rows.append([method, *each, f"**{_mean(values, 'flicker'):.2f}**", words[method]])
    return _table(rows)


def _restoration_table(figure: str, values: Mapping[str, Mapping[str, float]]) -> str:
    title = {
        "fig16": "Fig. 16, noise of sigma 20 of 255: dB / edge error",
        "fig17": "Fig. 17, JPEG of quality 10: dB / edge error",
    }[figure]
    rows = [[title, "damaged", "bilateral", "FBL", "FBL is above by", "bilateral at its best sigma_r"]]
    for name, found in values.items():
        each = [f"{found[f'{kind} dB']:.2f} / {found[f'{kind} edges']:.2f}" for kind in ("damaged", "bilateral", "fbl")]
        gain = f"**{found['fbl dB'] - found['bilateral dB']:+.2f} dB**"
        best = f"{found['best bilateral dB']:.2f} dB ({found['best bilateral sigma_r']:g})"
        rows.append([name, *each, gain, best])
    return _table(rows)


def _time_table(times: Mapping[str, Any]) -> str:
    rows = [["milliseconds at radius", *map(str, times["radii"]), "per px", "R²"]]
    for name, run in times["filters"].items():
        each = [f"{1000 * second:.1f}" for second in run["min"]]
        rows.append([name, *each, f"{1000 * run['line']['slope']:.2f}", f"{run['line']['r2']:.4f}"])
    return _table(rows)


def _table(rows: Sequence[Sequence[str]]) -> str:
    head, *body = rows
    lines = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines) + "\n"


def _mean(values: Mapping[str, Mapping[str, float]], key: str) -> float:
    return sum(value[key] for value in values.values()) / len(values)
