"""Every threshold of a vehicle's diagnosis in one place, each with its reason."""

import numpy as np

PERIOD = 0.04
"""[s] of the filter, about: bodies and rotors are slower than that. Where commands come at other instants than its
multiples, it is one near it that suits them."""
STEP = 0.0125
"""[s] Longest step of the plant inside the filter: one for each part of a period of 20 Hz."""
START = 1.0
"""[s] of a recording whose innovations do not count: they tell how it began. A vehicle that starts at full throttle is
20 deviations off until its velocity is found, and a random wrench ten times too large was learned from it."""
START_UNTOLD = 5.0
"""[s] The same without a velocity log: until drag has told the velocity. All evidence for a current that was not there,
24 nats, came from the first 3 s (tuning seed 1203)."""
SHARED = 0.05
"""Deviation of what all thrusters have in common, where the set states none."""
OWN = 0.02
"""Deviation of one thruster from the others: motors and propellers of one batch."""
TRIMMED = 0.01
"""Share of a vehicle's volume, and of its size, by which buoyancy and centre of mass differ from dive to dive: ballast,
another battery, the tether's end. One of 11 kg: 1.1 N and 2 mm. A set that does not say where the centre of mass is
along an axis is as unsure of it: taken for exact, one 0.3 mm off was a payload of 0.95 kg at odds of e^43. Where the
centre of buoyancy is tells its distance alone: one 5.5 mm below the origin, as moved, was an effect at e^119."""
CHARGED, EMPTYING = 0.05, 2e-4
"""Share of the nominal voltage, and [1/s] of it, by which a battery that no sensor reads is off at rest as a recording
begins, and changes: a lithium cell goes from 4.2 to 3.4 V, a tenth of it in ten minutes at work. Taken for full and
constant, a pack that lost 1 % in a minute was a fading of all motors, at odds of e^33."""
VOLTMETER = 0.02
"""Share by which readings of a battery's voltage are off where the thrusters' table names its volts. With a tenth, as
where a set holds at a voltage that nobody knows, a fit wandered off along volts and command_scale: 24 and 29 % off, 60
nats below the numbers that were right."""
POINTED, PLACED = 0.015, 0.02
"""[rad], and share of a vehicle's size (the cube root of its volume), by which a thruster is off what is drawn: 0.9
degrees, 5 mm of 13 l. Healthy vehicles with thrusters 1 degree and 5 mm off had three of them called misaligned, at
odds of e^24 to e^239, as long as places were taken for exact (tuning seeds 1301, 1303)."""
SLANTED = 0.02
"""Deviation of products of inertia over the root of both moments: no hull is symmetric to a percent. One of 0.037
kg m^2 beside 1.7 and 2.0 was a payload of 0.3 kg at 0.86 m to starboard, at odds of e^40."""
CORRELATION_TIMES = (0.3, 10.0)
"""[s] Of the random wrench, shortest and longest: eddies to tethers."""
LEAST_FORCE, LEAST_MOMENT = 1e-3, 1e-4
"""[N, N m] Random wrench that is assumed at least: no water is calmer, and gains stay finite."""
MOST_PUSHED = (1.0, 2.5)
"""[m/s^2, rad/s^2] Random acceleration that is assumed at most. Where no sensor tells a wrench, each round of learning
makes it larger: on a real vehicle without a velocity log it had reached hundreds of newtons."""
DRAWN = 0.05
"""Share of the range of a battery's current by which readings deviate at least: it goes with |gamma||n| of thrusters to
some percent only. Taken for exact it told viscous friction from the rotor's own damping, k_n (tuning seed 1202)."""
ANOTHER_UNIT, ANOTHER_BATTERY = 3.0, 1.25
"""Times what is foreseen that rotor speeds, or a battery's voltage, must be, or that must be them, to be asked about:
rpm, rad/s and revolutions a second differ by 6 and more, batteries by a cell in five."""
LONE_NOISE, LONE_SPREAD, LONE_MOST, LONE_EVERY = 10.0, 5.0, 0.1, 0.06
"""Noises, and ranges of its four neighbours, by which a reading that is left out stands off their median; the share of
readings from which on this is what the sensor tells; [s] longest spacing of a rotor's readings, as it may start and
stop between slower ones. Outliers of a hundred deviations bend a filter for seconds: a healthy vehicle with one
reading in a hundred was given a delay and a cavitation, at odds of e^28."""
MOST_DEVIATIONS = 4.0
"""Whitened readings beyond it count as it: one outlier in 16,000 is none under a normal distribution."""
P_EFFECT = 0.5
"""Prior probability that a recording that somebody wants diagnosed has an effect beyond its parameters."""
P_NAMELESS = 0.1
"""Share of it for effects that the library does not have."""
CLAIM = 30.0
"""Odds at which an effect is claimed against none of it: what the diagnosis of a single thruster asks too."""
SUSPECTED = 3.0
"""Odds above which an effect that is not claimed is not denied either."""
AT_AN_END, MORE_THAN_MOST = 0.4, 2.0
"""Share that is left of a claim's probability where recordings ask for a size beyond the range that is searched, by so
many of its deviations or more: something that acts alike is as likely then, and the verdict `cannot_tell`. Of fresh
vehicles by other authors both claims at an end were wrong, with p 1.00. A drag of 0.76 more that came out as 0.80 +-
0.10, the end of its range, was right (tuning seed 1414)."""
NAMELESS = 12.0
"""Gain in log evidence that a nameless dependence needs: 1 in 160,000 by chance, with some 200 of them tried."""
NAMELESS_SIZES = (1.0, 5.0, 25.0)
"""[N, 0.1 N m] Deviations that a nameless dependence may have, each as likely: with the smallest alone one of 2 N m
would cost 200 nats, and what it resembles would be named in its place."""
MOST_EFFECTS = 3
"""At a time: more have never been told apart from one recording session."""
ONSET = 1.0
"""[s] between the instants at which a failure may begin, to first order; a fit finds the instant. Set by reason."""
ABOUT_AS_LIKELY = 2.0
"""Log likelihood by which an onset may be behind the likeliest one and still be said to be possible: a deviation of two
where it goes with the square. A thruster that is idle for seconds tells nothing of them. Set by reason."""
REFINED = 8
"""Candidates that are fitted without linearisation: the right one was among the first four wherever it was found."""
REFINED_LATE = 2
"""The same of delays of all alike with which a search may begin. Set by reason."""
ALSO_LATE = 0.8
"""Share of what the likeliest delay gains beside re-tuned numbers, from which on another one is settled too: quick fits
beside each other's noises took an IMU 0.13 s late for a late command. Set by reason."""
REFINED_BACK = 4
"""The same of those of one thruster, from where its own numbers are as believed. Set by reason: where one was needed,
it was the first (tuning seed 1491, four recordings of a minute)."""
LEAST_TIME = 10.0
"""[s] of motion below which nothing is said."""
LONGEST, THINNED, STRETCH = 300.0, 240.0, 30.0
"""[s] Dives that are longer together are thinned to so much, in stretches of so much: some minutes of computing. Of a
stretch one to five seconds tell only how it began. Set by reason."""
LEAST_EXCITATION = 0.1
"""[V] Standard deviation of throttles below which a thruster tells nothing of itself."""
UNDETERMINED = 0.8
"""Share of its stated deviation that a number keeps, from which on a fit says that recordings do not determine it."""
SHIFTED = 3.0
"""Deviations by which a parameter must have moved to be named."""
HELD = 8.0
"""Deviations of a number from which on nothing is believed of effects that need it, nor of numbers alone: these only
resemble what is at work. Beside right effects of 17 dives by a generator of others none had moved by more than 3,
beside wrong ones some by 9 to 38; an accelerometer that vibration biases was a command 8.5 deviations off."""
HORIZONS = (2.0, 10.0)
"""[s] over which the model runs free: within one the attitude is near, within the other drag has acted."""
BLOCK = 2.0
"""[s] of the blocks whose scores are compared: longer than most disturbances are remembered, twenty in a run."""
LARGE_WRENCH, CALM_WRENCH = (1.2, 0.25), (0.6, 0.12)
"""[N, N m] Random wrench above which it is no eddy but something that the model lacks, and the largest one of pools and
harbours, against which there must be evidence for it: a minute holds six values of a wrench of ten seconds, and what
they make of its size may be twice as large. Of a vehicle of `SIZED`; eddies push others by their areas."""
ONE_AXIS = 3.0
"""Times the middle one of the three forces, or moments, of a random wrench, from which on one of them is not the
water's where there is evidence for it. An arm that swings every ten seconds pitched vehicles by 5 and 8 times that."""
SIZED = 0.0134
"""[m^3] A vehicle for which wrenches of water are given: the one of most of the seeds."""
WIRING_SEEN = 60.0
"""Chi squared of a command's column on six axes, above which it is seen to do something: 6 by chance."""
WIRING_MARGIN = 30.0
"""Chi squared that another order must gain, with directions taken as known to 15 %: 1 in a million by chance."""
TURNED_IMU, UPRIGHT = 2, 0.5
"""Wrong wires that a turned IMU is as unlikely as: one exchange stays one. Share of gravity that points down on the
mean of a recording once the IMU is read aright: a vehicle that floats upright tilts by less than 60 degrees then."""
TURNED_BY = 0.15
"""[rad] Deviation of the angle by which an IMU is said to be turned: so far directions of thrusts count as known."""
PULSE_MARGIN = 1.25
"""By which a dry run stays below its limits: righting moment and damping of a set deviate by 5 to 20 %."""
WATCH_THRESHOLD = 45.0
"""Log likelihood ratio at which the watch speaks: three seconds of the most that one may add. By Wald 14 would do for
10 h if the model were right. The highest of 60 healthy minutes of two tuning vehicles with good sensors was 30."""
WATCH_THRESHOLDS = (1.0, 1e6)
"""Between which a threshold may be set."""
WATCH_FORGET = 0.5
"""[1/s] by which a sum of log ratios falls beside what the data say: small misfit must not add up."""
WATCH_MOST = 15.0
"""[1/s] By how much the sum that grows most may grow, others in proportion: readings of a moment are wrong together, as
where the water in a slow thruster turns the other way than the filter thinks. Without it that added 86 and 107 in two
seconds (tuning seeds 102 and 177). A loss of 30 % gains 170 a second and is found in 3 s for 1 s."""
WATCH_DOUBT = 0.5
"""Share of what a failure would gain that is taken off. In an hour of three healthy vehicles (tuning seeds 101, 102,
106) the highest sum fell from 48 to 31 by it, and delays of losses at the height of that sum stayed what they were."""
WATCH_THRUST = 0.01
"""Share of a thrust by which it is not known: speeds and manoeuvres come that no healthy recording held."""
WATCH_WANDER = 300.0
"""[s] In which biases of sensors wander by what they differ by from dive to dive: those of a gyro that warms up change
in minutes. Set by reason."""
WATCH_SETTLING = 10.0
"""[s] after a start in which nothing accumulates and nothing is learned of the dive: flows through thrusters are still
being found. In 5 s a trim was learned of them that took a minute to be forgotten, and a thruster seemed to have lost
30 % meanwhile: log ratios of 73 and 541 in healthy dives (seeds 2061 and 2058), which are 4 and 28 by this alone."""
WATCH_KNOWN = 10.0
"""[s] after which what was learned of a dive is known. Without it an accelerometer 0.07 m/s^2 off made a velocity log
30 % wrong, with log ratios up to 133 in ten minutes of a healthy dive (seed 2095); 3 with it, 8 with 30 s."""
WATCH_JUMP = (5.0, 30.0)
"""[s] for which a sensor's jump is followed before its readings are freed of it; in which it must have been believed: a
slow sensor needs two dozen readings. Set by reason."""
WATCH_TOLD = 60.0
"""[s] for which it is told from then on. Set by reason."""
WATCH_STUCK = (5.0, 3.0)
"""[s] without a new reading after which a sensor is stuck or silent, at least; times the healthy vehicle's longest: its
readings may be coarse. Set by reason."""
WORTH = 0.25
"""Share of an effect's expected size below which it is kept in the model but not claimed: between a vehicle and a good
model of it many small things differ, and none of them is what anybody would repair."""
TURNS = 4
"""At most, of fitting numbers and learning noises in turn: they settle in two or three unless something is wrong."""
LEARNED = 4
"""Rounds of expectation and maximisation for noises, before they climb to where readings are most likely."""
CALMED = 0.05
"""Share of the random wrench with which numbers that are far from what was believed are fitted again where it is larger
than that of calm water: so little that it cannot explain what the numbers should. Set by reason."""
SETTLED = 2.0
"""Gain in log likelihood below which numbers and noises have settled: a sixth of what an effect must gain."""
ROUGH = 0.02
"""Share of its gain to which a fit goes whose noises are not learned yet, or learned anew behind it: that moves it by
more. Set by reason."""
FIT_STEPS = 8
"""Of Gauss and Newton, at most; they end where a step gains nothing. Set by reason."""
FITTED_ANEW, FAR_BEHIND = 4, 20.0
"""Candidates that are fitted along columns made anew at each step, and log evidence behind the best one of a quick fit
from which on that cannot change the answer: odds of 1 to 5e8. Set by reason; no seeds were run for it."""
FASTEST, FASTEST_FLOW = np.array([3.0] * 3 + [8.0] * 3), 2.0
"""[m/s, rad/s], [m/s] Beyond it a filter has lost the vehicle, and slopes there would lose its covariance too."""
FLOW_KNOWN = 0.003
"""[m/s] To which the flow through a thruster is known where nothing tells of it. Peaks of the watch in two dives in
calm water (seed 2058) fell from 541 and 64 to 8 and 4 by it. Log likelihoods of eight healthy recordings at true
parameters (tuning seeds 101 to 108, 30 s each) are 630 higher in all than with a doubt of thrusters below 5 rad/s
alone. At 1 mm/s they are 1,000 higher still, but then a watch took such a moment for a depth sensor's jump (seed 5)."""
FLOW_TIME = 0.2
"""[s] In which a flow that is not known changes a thrust: those of measured thrusters follow with 5 to 20 1/s."""
LATEST = 4.0
"""Deviations by which commands may act late without an effect: beyond it they are delayed, or stamped wrongly."""
TIMING = 0.003
"""[s] Deviation of the instant at which commands act, or a sensor reads, from the stamp: a driver's loop, a bus, half a
sample. Shifts in time came out as much as 5 ms off, with deviations of 0.1 to 1 ms from the readings alone."""
TOLD_APART = 5.0
"""Deviations by which a next recording must tell two effects apart; beyond it more is no better."""
REACH = 0.75
"""Of a period, by which an IMU may be later than where gains were made, or less late, before its readings are moved."""
CHARGE_TIME = 20.0
"""[s] In which a battery's charge is followed: it falls in minutes, while currents and what sags with them change in
seconds. Set by reason; no seeds were run for it."""
