// The text protocol: "%d\n" with a count from the host, "%d,%d\n" with two counts back, -99 ends the run.
#ifndef TEXT_H
#define TEXT_H

#include <stdbool.h>
#include <stdint.h>

void text_start(uint32_t now);                   // now in ms, as everywhere
bool text_receive(uint16_t byte, uint32_t now); // false: this is not text and no text session is on
void text_tick(uint32_t now);

#endif
