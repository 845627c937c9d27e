"""Every threshold of judgement: what it means, why it has this value, and on which cases that was looked at.

Tuning cases of the scoreboard have indices below 100,000; what is reported has others.
"""

from dataclasses import dataclass

__all__ = ["LOG_RULES", "RULES", "LogRules", "Rules"]


@dataclass(frozen=True, kw_only=True)
class Rules:
    """Thresholds of a diagnosis.

    Attributes:
        claimed: probability from which a group of look-alikes is claimed. A reader takes a name for a fact; nine in ten
            is what the report says it means.
        evident: evidence, prior included, by which the sets with effects must exceed none before anything is said to be
            wrong. Of 41 tuning cases without effect two exceeded it.
        apart: squared distance (Fisher, in standard deviations) below which two effects, or one and none, cannot be
            told apart: three standard deviations.
        alike: evidence by which a look-alike may be behind: nine halves is the same three standard deviations.
        pulled: share of an effect's energy outside the span of the parameters below which it counts as parametric.
        pressed: deviations by which the data want more of an effect than the largest plausible size; then it only
            resembles what is at work.
        held: deviations at which a parameter counts as held at its end: nothing is believed of a model that needs it.
        unsteady: evidence, nats, that an effect's size changes with run, time or state by more than its equation may be
            off, from which on it only resembles what is at work.
        helps: probability, by runs left out, that an effect makes a new run more probable; it is claimed from it on.
        conventional: time [s] up to which a lag or a delay is what simulators and loggers disagree about within a step,
            and what a clock may gain in a run.
        slight: share of the largest plausible size of an effect below which any model is off by as much: nobody would
            repair it. A rotor that brakes by 0.4 % more was claimed of a bench with five other effects.
        healthy_sensor: white noise over that of the samples themselves that a healthy sensor may have.
        healthy_colour: what it may carry beside, over its white noise.
        healthy_push: times the noise of their own sensors' readings that rotor and water may be pushed by.
        noteworthy: times the noise of its reading by which a push that is uneven or comes in bursts must move a state:
            below, no machine runs as evenly as its model.
        off: times the noise of a healthy thruster by which free runs of the re-tuned set must be off for effects to be
            asked which of them bring runs left out nearer.
        nameless: evidence for functions of states and inputs in what is left from which on something nameless is there.
            A search among some four hundred functions finds less by chance in 19 cases of 20.
        named: share of what re-tuning leaves that must be explained by named effects for the rest to belong to them.
        visible: cost that an effect of middle size has to take off so that it would have been found.
        power: share of the suspects that recordings must be able to show for "no gap" to mean anything.
        tempered: by how much evidence is divided, and variances of sizes and shares multiplied: what is simulated is
            never quite what was recorded.
        resembles: probability that an effect which only resembles what is at work is there after all.
    """

    claimed: float = 0.9
    evident: float = 6.0
    apart: float = 9.0
    alike: float = 4.5
    pulled: float = 0.002
    pressed: float = 3.0
    held: float = 15.0
    unsteady: float = 6.0
    helps: float = 0.5
    conventional: float = 4.5e-3
    slight: float = 0.01
    healthy_sensor: float = 1.3
    healthy_colour: float = 0.6
    healthy_push: float = 4.0
    noteworthy: float = 1.0
    off: float = 1.5
    nameless: float = 6.0
    named: float = 0.9
    visible: float = 25.0
    power: float = 0.5
    tempered: float = 1.5
    resembles: float = 0.1


RULES = Rules()


@dataclass(frozen=True, kw_only=True)
class LogRules:
    """Thresholds of what logs and residuals show before sets of effects are weighed.

    Attributes:
        spikes: share of spikes in a channel from which on they are an effect.
        ordinary: share of outliers that any logger may have, in any channel.
        chance: probability of that many spikes among so many outliers, below which they are none of those.
        jitter: logarithm of the odds from which on stamps are said to scatter.
        steep: scatter on a slope over the noise from which on it is seen by itself.
        remembered: share of a sample's error in the next one, and of all of them in common, that is not chance.
        fewest: samples on slopes that must be there to judge these.
        lattice: step over the noise's deviation from which on a converter counts.
        hole: reading [rad/s] from which on a tachometer that reads zero below it counts as blind.
        alike: share of a stated size within which a log shows what the set states.
        straight: evidence, nats, by which straight commands must fit better than held ones, as most devices hold them.
        rare: log odds against an effect that only scatters, before a log is seen.
        certain: log odds of what is seen rather than estimated, and the most that anything counts.
    """

    spikes: float = 0.012
    ordinary: float = 0.005
    chance: float = 1e-4
    jitter: float = 8.0
    steep: float = 2.0
    remembered: float = 0.2
    fewest: int = 30
    lattice: float = 1.0
    hole: float = 1.0
    alike: float = 0.1
    straight: float = 3.0
    rare: float = 3.0
    certain: float = 50.0


LOG_RULES = LogRules()
