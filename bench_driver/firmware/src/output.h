// The throttle outputs: converters, enable lines, and the rule by which they are enabled.
//
// An output is switched to 0 V unless it is enabled, and is enabled only by a command that sets zero.
#ifndef OUTPUT_H
#define OUTPUT_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"

#define LARGEST_CODE 4080
#define LARGEST_MILLIVOLTS 5000

void output_start(void);                                           // zero, all disabled
void output_disable(void);                                         // the same later
bool output_set_count(uint8_t count);                              // text: output 0; false, refused, until 128 came
void output_hold_zero_count(void);                                 // text: silence
bool output_set_millivolts(uint8_t i, bool enable, int16_t value); // frames: false if refused
uint8_t output_enabled(void);                                      // bit i = output i
uint16_t output_code(uint8_t i);

#endif
