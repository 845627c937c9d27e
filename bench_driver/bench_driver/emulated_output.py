"""The throttle outputs of a device and the rules by which they are enabled, as in the firmware's output.c.

An output is switched to zero volts unless it is enabled, and is enabled only by a command that sets zero. Text: the
first count 128 enables thruster 0, silence sets count 128. Frames: a command with flag and zero enables, silence sets
zero and disables.
"""

from bench_driver.converter import ZERO_CODE, code_from_count, code_from_millivolts, code_volts
from bench_driver.framed_messages import Command
from bench_driver.text_protocol import ZERO_COUNT

__all__ = ["EmulatedOutput"]


class EmulatedOutput:
    """Converters and enable lines of `thrusters` outputs, all disabled at first.

    Attributes:
        codes: the code of each converter.
        enabled: whether each output is switched to its converter.
    """

    def __init__(self, thrusters: int) -> None:
        self.codes = [ZERO_CODE] * thrusters
        self.enabled = [False] * thrusters

    @property
    def throttles(self) -> tuple[float, ...]:
        """Return what each thruster sees [V]."""
        return tuple(code_volts(code) if on else 0.0 for code, on in zip(self.codes, self.enabled, strict=True))

    def set_count(self, count: int) -> bool:
        """Set thruster 0 to a count of the text protocol; return False if it is refused because zero comes first."""
        if not (self.enabled[0] or count == ZERO_COUNT):
            return False
        self.codes[0] = code_from_count(count)
        self.enabled[0] = True
        return True

    def hold_zero_count(self) -> None:
        """Set thruster 0 to count 128 and leave it enabled."""
        self.codes[0] = code_from_count(ZERO_COUNT)

    def set_command(self, command: Command) -> int:
        """Set all thrusters; return how many are refused because zero comes first."""
        refused = 0
        for i, (throttle, enable) in enumerate(zip(command.throttles, command.enabled, strict=True)):
            held = enable and not self.enabled[i] and throttle != 0
            refused += held
            self.enabled[i] = enable and not held
            self.codes[i] = code_from_millivolts(throttle) if self.enabled[i] else ZERO_CODE
        return refused

    def disable(self) -> None:
        """Set zero and disable all."""
        self.codes = [ZERO_CODE] * len(self.codes)
        self.enabled = [False] * len(self.enabled)
