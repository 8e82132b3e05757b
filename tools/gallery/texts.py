"""The gallery's texts: the paper's claim in each figure, what our figure shows, and where ours falls short."""

from __future__ import annotations

from typing import NamedTuple


class Text(NamedTuple):
    """The words beside a sheet, in Markdown."""

    claim: str
    see: str


TEXTS: dict[str, Text] = {
    "fig01": Text(
        claim="Line extraction conveys the shapes, region flattening removes insignificant detail, and both together "
        "give a cartoon.",
        see="the drawing (b) keeps the outlines, folds and features; flattening (c) leaves a few even tones; together "
        "(d) they read as a cartoon. With the printed values, hard levels put contours of their own into the soft "
        "background.",
    ),
    "fig03": Text(
        claim="The flow preserves edge directions around important features and is smooth elsewhere.",
        see="streaks run round the eyes, along the fur and the leaves, up the columns and round the arch. Where "
        "nothing has an edge (the bright doorway, the blurred background) the flow swirls as the noise there has "
        "it.",
    ),
    "fig04": Text(
        claim="The flow gets smoother after each iteration; two or three do.",
        see="the speckle of the first iteration joins into long, even streaks by the third; eyes and stripes stay "
        "where they are.",
    ),
    "fig05": Text(
        claim="A pass along x and one along y give nearly the same flow: the mean colour distance is 0.00893 on the "
        "paper's picture.",
        see="the same structure, but not the same picture: on six photographs the distance is .084 to .129 (median .03 "
        "to .06). It is not spread evenly. A fifth to a third of the pixels, where no direction dominates, hold 71 to "
        "81 % of it; the quarter with the weakest gradients differs two to five times as much as the strongest 3 %. "
        "Whatever makes the flow less ambiguous shrinks it: a pre_blur of 1 with fill 2 gives .03 to .07, a pre_blur "
        "of 8 .02 to .03, and a clean drawn disc .0028, below the paper's number, which is then one of a picture with "
        "clear edges. Nor is separability the main cause: the same passes summed exactly over a square of equal area "
        "still differ from the disc by .05 to .075. Averaging x-then-y with y-then-x gains 5 to 8 %. The better answer "
        "is no approximation: since eqs. 4 and 5 are a product with a tensor, the full disc is made of running sums, "
        "exact, linear in the radius, and no slower. It is the default.",
    ),
    "fig07": Text(
        claim="FDoG is more coherent than the isotropic DoG. sigma_m sets the coherence, sigma_c the width of a "
        "line; a higher rho draws more lines.",
        see="the specks of DoG (b) are gone in (c), with a third of the pieces, each longer; a short kernel (d) is "
        "half-way back to DoG; sigma_c 2 (e) draws with a broad pen; rho 0.997 (f) adds whiskers and faint edges.",
    ),
    "fig08": Text(
        claim="With the flow of a blurred picture and a large kernel, FDoG joins disconnected points into the "
        "line that people see; junctions and crossings too.",
        see="DoG (b, g, l) leaves each dot alone. FDoG closes the circle (d), and draws the four arms of the X (i) and "
        "the two strokes of the T (n), with a gap where they meet: the flow has no one direction there. Two more "
        "iterations with a little blur before each, section 3.2, close the gaps (j, o); strokes get thicker.",
    ),
    "fig09": Text(
        claim="On a shape in Gaussian noise, isotropic DoG is incoherent at a low threshold and full of clutter at a "
        "high one; FDoG draws a clean, coherent line at the low one.",
        see="DoG at either threshold, and even at the best that can be found for it, drowns the circle in specks; "
        "FDoG at the low threshold draws it whole, and nothing else. The F-score counts ink within 2.5 pixels of "
        "the true contour; other draws of the noise leave a gap or a speck. The paper prints neither rho nor the "
        "flow's values here: 0.97 is the low end of the range it names, and the flow comes from a blurred "
        "picture, as in Fig. 8.",
    ),
    "fig10": Text(
        claim="A flow whose kernel is larger than the texture misses its shapes, and the lines fail with it; a small "
        "kernel draws them.",
        see="a net of lines eight pixels apart. Radius 3 (b) draws it; with radius 5 (c) the flow runs across the "
        "cells and the lines with it, as the paper says. Radius 5 with `adaptive` (d), the paper's own suggestion for "
        "later work, takes a smaller kernel where the picture needs it, and draws the net again.",
    ),
    "fig11_13": Text(
        claim="Each further application, with the ink so far laid over the picture, makes the boundaries more "
        "coherent. Isotropic DoG conveys more of the tone; and noise that the first pass draws is kept by "
        "the later ones.",
        see="from DoG to FDoG's third iteration pieces become fewer and several times longer: rings of the collar "
        "close, column edges run through. As the paper says, later passes also keep what is noise: dashes on the "
        "floor, in the fur and on the visor.",
    ),
    "fig14": Text(
        claim="FDoG captures perceptually meaningful structures and draws them with smooth, coherent lines.",
        see="Canny is thin and even, and breaks at corners; segments of mean shift have rough borders all over; DoG "
        "is specked; FDoG has fewer, longer strokes that swell with the contrast. The borders of (c) are Canny's "
        "edges of the segmented picture.",
    ),
    "fig16": Text(
        claim="On a noisy picture, FBL restores the boundary of a shape better than the full-kernel bilateral filter, "
        "which leaves noise along it.",
        see="the bilateral filter at these values takes noise of sigma 20 for detail and leaves it; FBL removes it in "
        "the areas and along the rim, and the rim stays sharp. Faint highlights and wood grain are lost. PSNR is "
        "against the photograph without noise; [side by side](../compare/README.md) has it for more pictures: "
        "most on smooth shapes, least on fur and grain.",
    ),
    "fig17": Text(
        claim="On a heavily compressed picture, the bilateral filter keeps the blocks; FBL restores clean and smooth "
        "boundaries.",
        see="stairs along the eye, the lid and the nose in (e, f, h, i) are smooth curves in (g, j). Blocks of wrong "
        "colour inside a region, such as the orange one above the eye, stay in both: with sigma_g 0.3 hardly "
        "anything moves across the flow. In PSNR the two are within half a dB on [every "
        "picture](../compare/README.md), FBL mostly above: boundaries are few pixels.",
    ),
    "fig18": Text(
        claim="FBL reinforces the shapes of single hairs, which the bilateral filter blurs away; flattened, the "
        "pattern stays sharp.",
        see="in (c, g) the fur melts to patches; in (d, h) hairs stay, and run together to strands. Flattened, "
        "strokes of fur are left in (f) where (e) has blots.",
    ),
    "fig19": Text(
        claim="On small isotropic texture the full-kernel bilateral filter stays closest to the original; FBL makes "
        "boundaries smoother, and has none of the axis-aligned artefacts of the xy-separable one.",
        see="on blurred noise, the bilateral filter (b) keeps shapes round and near the input; the xy-separable (c) "
        "squares them off, see the ends of the bars; FBL (d) follows the flow, smooth, but with shapes of its own. In "
        "grass (f, g, h) the three differ by little at these values.",
    ),
    "fig20": Text(
        claim="The more a kernel can follow the picture, the better shapes are protected and enhanced.",
        see="the bilateral kernels (b, c) leave stairs at the lid. A straight line (d) cuts across the bend and "
        "washes out pupil and highlight; the arc (e) holds the curve but strays where it bends otherwise; the "
        "free curve (f) keeps the pupil and has the smoothest lid. The paper prints no values here: sigma_e 6 "
        "makes the kernel long enough to show the difference.",
    ),
    "fig21": Text(
        claim="Mean-shift regions have rough boundaries; the bilateral filter's are smoother but lose some "
        "directional features; FBL has smooth boundaries and keeps the features' directions.",
        see="mean shift's borders are ragged (f, n); the bilateral filter's are cleaner, with leftover specks; FBL's "
        "are smooth, and strands of fur keep their direction. Mean shift keeps more of the tones, having no "
        "levels.",
    ),
    "fig24": Text(
        claim="Lines and flattened colour together convey shape and tone; for some pictures lines alone, or colour "
        "alone, do better.",
        see="the same graph on five photographs. Fur, wood grain and spoons take more strokes than an artist would "
        "give them: the paper's values draw every edge; the shipped graph `abstraction` has calmer ones.",
    ),
    "fig25": Text(
        claim="The same values do on a large photograph.",
        see="at 1024x768 strokes as wide as the paper's are fine hatching in the fur; leaves, eyes and outline stay "
        "clear.",
    ),
    "xdog": Text(
        claim="nothing of this: XDoG (Winnemöller, Kyprianidis, Olsen, 2012) came later. It takes the same difference "
        "of Gaussians as a sharpened picture, and lets lines fade into tone.",
        see='`form` "xdog" of the line nodes, along the flow. With epsilon 0 there are edges alone, softly (b). With a '
        "level, tone darkens below it, soft (c, d) or hard (e), without hatching in dark areas. A high level turns "
        "what is dark to ink, and edges in it to white lines (f).",
    ),
}
