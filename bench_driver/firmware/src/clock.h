// Time since the reset, from timer 1.
#ifndef CLOCK_H
#define CLOCK_H

#include <stdint.h>

void clock_start(void);
uint32_t clock_milliseconds(void);
uint32_t clock_microseconds(void); // in steps of 0.5 us, truncated; wraps after 71.6 minutes

#endif
