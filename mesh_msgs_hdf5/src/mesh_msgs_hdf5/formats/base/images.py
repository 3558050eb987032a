"""Textures: images of other programs to arrays, and arrays to PNG."""
import io
import warnings

import numpy as np
import PIL
from PIL import Image

_FORMATS = ("PNG", "JPEG", "BMP", "TGA", "TIFF", "GIF", "WEBP")
_VARIANTS = ("MPO",)  # JPEG of several views, as some cameras write it
# Pillow before 8.0 cannot choose
_ONLY = {"formats": _FORMATS} if int(PIL.__version__.split(".")[0]) >= 8 else {}
# a picture of 11,000 by 11,000 pixels; what says that it is larger is not decoded
MAX_PIXELS = 1 << 27
_PLAIN = ("RGB", "RGBA")


class ImageError(Exception):
    """Why an image cannot be a texture."""


def decoded(data: bytes) -> np.ndarray:
    """(height, width, 3 or 4) uint8 of an image file's bytes; raises ImageError."""
    try:
        with warnings.catch_warnings():
            # the size is looked at here, before anything is decoded
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(data), **_ONLY) as image:
                if image.format not in _FORMATS + _VARIANTS:
                    raise ImageError("is of the format %s, which is not read" % image.format)
                if image.width * image.height > MAX_PIXELS:
                    raise ImageError(
                        "has %d x %d pixels, more than %d" % (image.width, image.height, MAX_PIXELS)
                    )
                return np.array(_plain(image))
    except ImageError:
        raise
    except Exception as error:  # decoders of damaged files raise whatever happens to them
        reason = str(error) or type(error).__name__
        raise ImageError("is no image that can be read: %s" % reason.split("<_io")[0]) from error


def _plain(image: Image.Image) -> Image.Image:
    if image.mode in _PLAIN:
        return image
    if image.mode.startswith("I"):  # 16 bits of gray
        high = np.asarray(image).astype(np.int64) >> 8
        return Image.fromarray(np.clip(high, 0, 255).astype(np.uint8)).convert("RGB")
    if image.mode == "F":
        raise ImageError("has pixels of floats, not of bytes")
    alpha = image.mode in ("LA", "PA", "La", "RGBa") or "transparency" in image.info
    return image.convert("RGBA" if alpha else "RGB")


def png(image: np.ndarray) -> bytes:
    """The bytes of a PNG file of (height, width, 3 or 4) uint8; lossless."""
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(image)).save(stream, "PNG", compress_level=3)
    return stream.getvalue()
