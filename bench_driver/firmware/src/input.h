// The analogue inputs: 10-bit counts, 5 V full scale.
#ifndef INPUT_H
#define INPUT_H

#include <stdint.h>

void input_start(void);
uint16_t input_count(uint8_t channel); // 0 to 15; takes 0.1 ms

#endif
