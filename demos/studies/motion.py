"""The animation of the README, of a few hundred kB: a thin channel that twists until its flange buckles."""

from dataclasses import replace
from pathlib import Path

from PIL import Image

import sheetfx as fx
from sheetfx.scenes import channel
from sheetfx.show.animating import COLOURS

FILE, SIZE = Path(__file__).parents[1] / "channel.gif", (720, 315)

case = channel.case()
record = fx.trace(replace(case, control=replace(case.control, largest=0.35)))
record.animate(FILE)
with Image.open(FILE) as picture:
    frames, shown = [], []
    for number in range(picture.n_frames - 1, -1, -2)[::-1]:  # each second one, the last one too
        picture.seek(number)
        shown.append(picture.info["duration"])
        frame = picture.convert("RGB").resize(SIZE, Image.Resampling.LANCZOS)
        frames.append(frame.quantize(COLOURS, Image.Quantize.FASTOCTREE))
frames[0].save(FILE, save_all=True, append_images=frames[1:], loop=0, duration=shown)
print(FILE.name, len(frames), "frames", FILE.stat().st_size // 1000, "kB")
