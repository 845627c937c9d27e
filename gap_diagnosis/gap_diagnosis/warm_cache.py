"""Compile what a diagnosis needs into the cache, by diagnosing a short one:   python -m gap_diagnosis.warm_cache"""

from gap_diagnosis.scoreboard.plans import planned
from gap_diagnosis.scoreboard.running_io import diagnosed


def main() -> None:
    """Diagnose the first case without an effect: all suspects are tried beside it."""
    diagnosed(planned("smoke", ("tank",))[0])


if __name__ == "__main__":
    main()
