"""Damaged copies of a file, each from its number alone."""
import numpy as np

# what HDF5's own records begin with
SIGNATURES = (b"\x89HDF", b"OHDR", b"OCHK", b"TREE", b"HEAP", b"SNOD", b"GCOL", b"FRHP", b"BTHD")
LIES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)


class Mutations:
    """Mutations of one file; the number decides kind and place."""

    def __init__(self, data: bytes) -> None:
        self._data = np.frombuffer(data, np.uint8)
        self._records = [0]
        for signature in SIGNATURES:
            place = data.find(signature)
            while place >= 0:
                self._records.append(place)
                place = data.find(signature, place + 1)
        self._kinds = (
            self._bit,
            self._bits,
            self._run,
            self._run_near_record,
            self._lie,
            self._lie_near_record,
            self._bit_near_record,
            self._zeros,
            self._swap,
            self._copy,
            self._cut,
            self._longer,
            self._superblock,
        )

    def __call__(self, number: int) -> bytes:
        rng = np.random.default_rng([2024, number])
        data = self._data.copy()
        changed = self._kinds[number % len(self._kinds)](data, rng)
        return (data if changed is None else changed).tobytes()

    def kind(self, number: int) -> str:
        """Its name, for messages."""
        return self._kinds[number % len(self._kinds)].__name__.strip("_")

    def _place(self, rng, length):
        return int(rng.integers(0, len(self._data) - length))

    def _near(self, rng, length):
        """A place in an object header, B-tree or heap, or in a message behind it."""
        start = self._records[rng.integers(len(self._records))] + int(rng.integers(0, 400))
        return min(start, len(self._data) - length)

    def _bit(self, data, rng):
        data[self._place(rng, 1)] ^= 1 << rng.integers(8)

    def _bits(self, data, rng):
        for _ in range(rng.integers(2, 20)):
            self._bit(data, rng)

    def _bit_near_record(self, data, rng):
        data[self._near(rng, 1)] ^= 1 << rng.integers(8)

    def _run(self, data, rng, place=None):
        length = int(rng.integers(1, 64))
        start = self._place(rng, length) if place is None else place(rng, length)
        data[start : start + length] = rng.integers(0, 256, length)

    def _run_near_record(self, data, rng):
        self._run(data, rng, self._near)

    def _lie(self, data, rng, place=None):
        """A number that says too much or nothing, of 1, 2, 4 or 8 bytes."""
        length = 1 << int(rng.integers(4))
        start = self._place(rng, length) if place is None else place(rng, length)
        number = LIES[rng.integers(len(LIES))]
        data[start : start + length] = list(number.to_bytes(8, "little")[:length])

    def _lie_near_record(self, data, rng):
        self._lie(data, rng, self._near)

    def _zeros(self, data, rng):
        length = int(rng.choice([16, 64, 512, 4096]))
        length = min(length, len(data) // 4)
        start = self._place(rng, length)
        data[start : start + length] = 0

    def _blocks(self, data, rng):
        length = int(rng.choice([8, 32, 256, 1024]))
        length = min(length, len(data) // 4)
        one, other = (self._place(rng, length) // 8 * 8 for _ in range(2))
        return slice(one, one + length), slice(other, other + length)

    def _swap(self, data, rng):
        one, other = self._blocks(data, rng)
        kept = data[one].copy()
        data[one] = data[other]
        data[other] = kept

    def _copy(self, data, rng):
        one, other = self._blocks(data, rng)
        data[one] = data[other].copy()

    def _cut(self, data, rng):
        return data[: self._place(rng, 1)]

    def _longer(self, data, rng):
        return np.concatenate(
            [data[: self._place(rng, 1)], rng.integers(0, 256, 999), data]
        ).astype(np.uint8)

    def _superblock(self, data, rng):
        for _ in range(rng.integers(1, 4)):
            data[rng.integers(8, 96)] = rng.integers(0, 256)
