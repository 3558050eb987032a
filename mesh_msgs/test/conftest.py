"""Where the tests of all rooms find what they share."""
import sys
from pathlib import Path

from mesh_msgs.testing import expect_a_busy_machine

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))
expect_a_busy_machine()
