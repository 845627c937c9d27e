// Times that both protocols share, in ms.
#ifndef TIMING_H
#define TIMING_H

#define WATCHDOG_MS 200 // without a command: zero
#define SESSION_MS 1000 // without a sign of the host: the session is over
#define PROBE_MS 300    // listening for frames before going back to text
#define STATE_MS 10     // between two states: 100 Hz

#endif
