#!/usr/bin/env python3
"""A reader of its own of the `.btf` files of the University of Bonn, to hold another one's files against.

  read_btf.py (TOLERANCE FILE.btf EXPECTED)...    EXPECTED: raw float32 [view][light][y][x][rgb]

Exit status 1 if a file is not what is expected of it, to the tolerance (relative to the largest value).
"""
import struct
import sys

import numpy as np

YUV = np.array([[1, 0, 1.13983], [1, -0.39465, -0.5806], [1, 2.03211, 0]])
YCOCG = np.array([[1, 1, -1], [1, 0, 1], [1, -1, -1]], float)
EPS = 1e-5


class File:
    def __init__(self, path):
        self.data, self.at = open(path, "rb").read(), 0

    def get(self, form):
        form = "<" + form
        values = struct.unpack_from(form, self.data, self.at)
        self.at += struct.calcsize(form)
        return values[0] if len(values) == 1 else values

    def skip(self, count):
        self.at += count

    def array(self, size, *shape):
        count = int(np.prod(shape))
        values = np.frombuffer(self.data, {2: "<f2", 4: "<f4", 8: "<f8"}[size], count, self.at)
        self.at += count * size
        return values.reshape(shape).astype(float)


def to_rgb(x, model, mean, matrix):  # x: [..., 3]
    if model in (9, 10, 11):
        y = np.exp(x[..., 0]) - EPS
        uv = x[..., 1:]
        if model == 10:
            uv = np.sign(uv) * np.exp(np.abs(uv)) * EPS
        if model == 11:
            uv = uv * (y + EPS)[..., None]
        return np.concatenate([y[..., None], uv], -1) @ YUV.T
    if model == 5:
        rest = x[..., 1:] * x[..., :1]
        return np.concatenate([x[..., :1] - rest.sum(-1, keepdims=True), rest], -1)
    return {0: lambda: x, 1: lambda: x @ YUV.T, 3: lambda: x @ matrix + mean, 4: lambda: x @ YCOCG.T,
            12: lambda: np.exp(x) - EPS}[model]()


def factors(f):
    size, rank, rows, columns = f.get("BIII")
    f.array(size, rank)
    return f.array(size, rows, rank), f.array(size, columns, rank)


def read(path):
    f = File(path)
    signature = max((s for s in (b"!DFMF08FCR", b"!FMF12FCER", b"!FMF06FCR", b"!FMF06FC", b"!PVF06FCR", b"!PVF06FC",
                                 b"!BDIF06R2!") if f.data.startswith(s)), key=len)
    f.at = len(signature)
    begin = f.at
    size, version = f.get("II")
    f.at += 240 + 16
    if version > 1:
        f.get("I")
    if version > 2:
        f.skip(f.get("I"))
    if version > 3:
        for _ in range(f.get("I")):
            f.skip(f.get("I"))
    assert f.at - begin == size, "meta data"
    for v in range(views := f.get("I")):
        f.get("ff")
        lights = f.get("I")
        f.at += 8 * lights
    w, h = f.get("II")
    if signature.endswith(b"R"):
        f.skip(36 * f.get("I"))
    pairs, texels = views * lights, w * h
    if signature.startswith(b"!DFMF"):
        _, model = f.get("Ii")
        mean, matrix = f.array(4, 3), f.array(4, 3, 3)
        planes = []
        for _ in range(3):
            left, right = factors(f)
            planes.append(left @ right.T if len(left) == pairs else (left @ right.T).T)
        values = to_rgb(np.stack(planes, -1), model, mean, matrix)
    elif signature.startswith(b"!FMF"):
        logarithmic = False
        if b"E" in signature:
            extension = f.get("B")
            logarithmic = extension >= 1 and f.get("I") != 0
            if extension >= 2:
                f.skip(2 * int(np.prod(f.get("II"))))
        f.get("I")
        left, right = factors(f)
        matrix = left @ right.T
        values = (matrix.reshape(pairs, 3, texels).transpose(0, 2, 1) if len(left) == 3 * pairs
                  else matrix.reshape(texels, 3, pairs).transpose(2, 0, 1))
        values = np.exp(values) - EPS if logarithmic else values
    elif signature.startswith(b"!PVF"):
        f.get("II")
        values = []
        for _ in range(views):
            size, rank, weights, dimension = f.get("BIII")
            f.array(size, rank)
            mean, c, k = f.array(size, dimension), f.array(size, dimension, rank), f.array(size, weights, rank)
            x = mean[:, None] + c @ k.T
            values.append(x.reshape(lights, 3, texels).transpose(0, 2, 1) if dimension == 3 * lights
                          else x.reshape(texels, 3, lights).transpose(2, 0, 1))
        values = np.stack(values)
    else:
        lines, compression = f.get("IB")
        mask = np.frombuffer(f.data, np.uint8, texels, f.at) != 0
        f.at += texels
        f.skip(36 * f.get("I"))
        stored = np.flatnonzero(mask) if compression == 2 else np.arange(texels)
        values = np.zeros((texels, pairs, 3))
        for first in range(0, len(stored), w * lines):
            chunk = stored[first:first + w * lines]
            assert f.get("I") == 6 * pairs * len(chunk), "chunk"
            values[chunk] = f.array(2, len(chunk), pairs, 3)
        values = values.transpose(1, 0, 2)
    assert f.at == len(f.data), "bytes are left"
    return values.reshape(views, lights, h, w, 3)


def main(arguments):
    assert arguments and len(arguments) % 3 == 0, __doc__
    status = 0
    for tolerance, path, expected in zip(*[iter(arguments)] * 3):
        values, wanted = read(path), np.fromfile(expected, "<f4")
        error = np.abs(values.ravel() - wanted).max() / np.abs(wanted).max() if values.size == wanted.size else np.inf
        if not error <= float(tolerance):
            print(f"{path}: differs by {error}", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
