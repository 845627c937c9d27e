// The framed protocol at 100 Hz; the layout is told in bench_driver/framed_protocol.py and framed_messages.py.
#ifndef FRAMES_H
#define FRAMES_H

#include <stdbool.h>
#include <stdint.h>

void frames_start(uint8_t reset_cause);           // listen; forgets counters and the session before
void frames_receive(uint16_t byte, uint32_t now); // now in ms
void frames_tick(uint32_t now);                   // while a session is on
bool frames_session(uint32_t now);                // a valid frame came, the last one less than a second ago

#endif
