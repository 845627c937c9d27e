#include "frames.h"

#include <avr/wdt.h>
#include <string.h>

#include "board.h"
#include "clock.h"
#include "crc.h"
#include "input.h"
#include "output.h"
#include "timing.h"
#include "uart.h"

enum { COMMAND = 0x01, STOP = 0x02, ASK_HELLO = 0x03, ASK_RESET = 0x04, STATE = 0x81, HELLO = 0x83 };
enum { SYNC_0 = 0xA5, SYNC_1 = 0x5A, HEAD = 10, CHECK = 4, VERSION = 1 };
enum { COMMAND_LENGTH_MIN = 3, COMMAND_LENGTH_MAX = 17, LONGEST_RECEIVED = HEAD + COMMAND_LENGTH_MAX + CHECK };
enum { STATE_LENGTH = 21 + 6 * THRUSTERS + 2 * LOADS, HELLO_LENGTH = 10 };

// In the order of the state's payload.
static struct { uint16_t wrong_checksum, garbage, bad_header, missing, overruns, refused, watchdog; } errors;

static uint8_t pending[LONGEST_RECEIVED], waiting;
static uint8_t cause;
static bool session, heard, commands_missing;
static uint16_t sequence, echo;
static uint32_t last_frame, last_command, next_state;

void frames_start(uint8_t reset_cause) {
    memset(&errors, 0, sizeof errors);
    cause = reset_cause;
    waiting = 0;
    echo = 0;
    session = heard = false;
}

static uint8_t *put16(uint8_t *at, uint16_t value) {
    *at++ = value & 0xFF;
    *at++ = value >> 8;
    return at;
}

static uint8_t *put32(uint8_t *at, uint32_t value) { return put16(put16(at, value & 0xFFFF), value >> 16); }

// The payload stands at frame + HEAD already.
static void send(uint8_t *frame, uint8_t type, uint8_t length, uint32_t time) {
    frame[0] = SYNC_0;
    frame[1] = SYNC_1;
    frame[2] = length;
    frame[3] = type;
    put32(put16(frame + 4, sequence++), time);
    put32(frame + HEAD + length, crc32(frame + 2, HEAD - 2 + length));
    uart_write(frame, HEAD + length + CHECK);
}

static void send_hello(void) {
    uint8_t frame[HEAD + HELLO_LENGTH + CHECK], *at = frame + HEAD;
    *at++ = VERSION;
    *at++ = cause;
    *at++ = THRUSTERS;
    *at++ = LOADS;
    at = put16(at, 1000 / STATE_MS);
    at = put16(at, WATCHDOG_MS);
    put16(at, LARGEST_CODE);
    send(frame, HELLO, HELLO_LENGTH, clock_microseconds());
}

static void send_state(uint32_t now) {
    uint8_t frame[HEAD + STATE_LENGTH + CHECK], *at = frame + HEAD;
    uint32_t age = now - last_frame, time = clock_microseconds();
    errors.overruns = uart_overruns();
    *at++ = output_enabled();
    *at++ = commands_missing;
    at = put16(at, echo);
    at = put16(at, age > 0xFFFF ? 0xFFFF : age);
    at = put16(at, errors.wrong_checksum);
    at = put16(at, errors.garbage);
    at = put16(at, errors.bad_header);
    at = put16(at, errors.missing);
    at = put16(at, errors.overruns);
    at = put16(at, errors.refused);
    at = put16(at, errors.watchdog);
    *at++ = THRUSTERS | LOADS << 4;
    for (uint8_t i = 0; i < THRUSTERS; i++) at = put16(at, input_count(TACHOMETER_INPUT(i)));
    for (uint8_t i = 0; i < THRUSTERS; i++) at = put16(at, input_count(FLOW_INPUT(i)));
    for (uint8_t i = 0; i < THRUSTERS; i++) at = put16(at, output_code(i));
    for (int8_t j = 0; j < LOADS; j++) at = put16(at, input_count(LOAD_INPUT(j)));
    send(frame, STATE, STATE_LENGTH, time);
}

static int16_t throttle(const uint8_t *payload, uint8_t i) {
    return (int16_t)(payload[1 + 2 * i] | (uint16_t)payload[2 + 2 * i] << 8);
}

static void obey(const uint8_t *payload, uint8_t length, uint32_t now) {
    bool valid = length == 1 + 2 * THRUSTERS && !((uint16_t)payload[0] >> THRUSTERS);
    for (uint8_t i = 0; valid && i < THRUSTERS; i++)
        valid = throttle(payload, i) >= -LARGEST_MILLIVOLTS && throttle(payload, i) <= LARGEST_MILLIVOLTS;
    if (!valid) {
        errors.refused++;
        return;
    }
    last_command = now;
    commands_missing = false;
    for (uint8_t i = 0; i < THRUSTERS; i++)
        errors.refused += !output_set_millivolts(i, payload[0] & _BV(i), throttle(payload, i));
}

static void handle(const uint8_t *frame, uint32_t now) {
    uint16_t number = frame[4] | (uint16_t)frame[5] << 8, step = number - echo;
    if (!session) {
        session = true;
        output_disable();
        sequence = 0;
        last_command = now;
        commands_missing = false;
        next_state = now + STATE_MS;
        send_hello();
    }
    last_frame = now;
    if (heard && step > 1 && step < 0x8000) errors.missing += step - 1;
    heard = true;
    echo = number;
    switch (frame[3]) {
    case COMMAND: obey(frame + HEAD, frame[2], now); break;
    case STOP: output_disable(); break;
    case ASK_HELLO: send_hello(); break;
    case ASK_RESET:
        output_disable();
        wdt_enable(WDTO_15MS);
        for (;;) {}
    }
}

static bool possible(uint8_t type, uint8_t length) {
    if (type == COMMAND) return length >= COMMAND_LENGTH_MIN && length <= COMMAND_LENGTH_MAX && (length & 1);
    return type >= STOP && type <= ASK_RESET && length == 0;
}

static void drop(uint8_t n) {
    waiting -= n;
    memmove(pending, pending + n, waiting);
}

// Take one step with the bytes that wait; false if more are needed.
static bool parse(uint32_t now) {
    if (waiting && (pending[0] != SYNC_0 || (waiting > 1 && pending[1] != SYNC_1))) {
        errors.garbage++;
        drop(1);
        return true;
    }
    if (waiting < HEAD) return false;
    if (!possible(pending[3], pending[2])) {
        errors.bad_header++;
        drop(1);
        return true;
    }
    uint8_t body = HEAD + pending[2], found[CHECK];
    if (waiting < body + CHECK) return false;
    put32(found, crc32(pending + 2, body - 2));
    if (memcmp(found, pending + body, CHECK)) {
        errors.wrong_checksum++;
        drop(1);
    } else {
        handle(pending, now);
        drop(body + CHECK);
    }
    return true;
}

void frames_receive(uint16_t byte, uint32_t now) {
    pending[waiting++] = byte; // there is room: a frame that is whole never waits
    while (parse(now)) {}
}

void frames_tick(uint32_t now) {
    if (now - last_command >= WATCHDOG_MS && !commands_missing) {
        commands_missing = true;
        errors.watchdog++;
        output_disable();
    }
    if ((int32_t)(now - next_state) >= 0) {
        next_state += STATE_MS;
        send_state(now);
    }
}

bool frames_session(uint32_t now) { return session && now - last_frame < SESSION_MS; }
