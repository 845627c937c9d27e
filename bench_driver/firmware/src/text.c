#include "text.h"

#include "board.h"
#include "input.h"
#include "output.h"
#include "timing.h"
#include "uart.h"

#define LONGEST_LINE 10 // "1023,1023\r", also the host's decoder's limit
#define LARGEST_COUNT 255

static char line[LONGEST_LINE];
static uint8_t length;
static bool too_long, counted, ended;
static uint32_t last_count, last_byte;

void text_start(uint32_t now) {
    length = 0;
    too_long = counted = ended = false;
    last_byte = now;
}

// The value of "0" or of 1 to 4 digits without a leading zero, else -1.
static int16_t integer(void) {
    if (length < 1 || length > 4 || (line[0] == '0' && length > 1)) return -1;
    int16_t value = 0;
    for (uint8_t i = 0; i < length; i++) {
        if (line[i] < '0' || line[i] > '9') return -1;
        value = 10 * value + (line[i] - '0');
    }
    return value;
}

static uint8_t digits(uint8_t *at, uint16_t value) {
    uint8_t n = value > 999 ? 4 : value > 99 ? 3 : value > 9 ? 2 : 1;
    for (uint8_t i = n; i-- > 0; value /= 10) at[i] = '0' + value % 10;
    return n;
}

static void answer(void) {
    uint8_t reading[LONGEST_LINE], n;
    n = digits(reading, input_count(TACHOMETER_INPUT(0)));
    reading[n++] = ',';
    n += digits(reading + n, input_count(FLOW_INPUT(0)));
    reading[n++] = '\n';
    uart_write(reading, n);
}

static void end_of_line(uint32_t now) {
    if (length && line[length - 1] == '\r') length--;
    if (length == 3 && line[0] == '-' && line[1] == '9' && line[2] == '9') {
        output_disable();
        ended = true;
        return;
    }
    int16_t count = integer();
    if (count < 0 || count > LARGEST_COUNT) return;
    counted = true;
    last_count = now;
    if (output_set_count(count)) answer(); // else silence, which tells the host of a reset that zero has to come first
}

bool text_receive(uint16_t byte, uint32_t now) {
    last_byte = now;
    bool text = (byte >= '0' && byte <= '9') || byte == '-' || byte == '\r' || byte == '\n';
    if (!text && !(counted && now - last_count < SESSION_MS)) return false;
    if (ended) return true;
    if (byte == '\n') {
        if (!too_long) end_of_line(now);
        length = 0;
        too_long = false;
    } else if (length < LONGEST_LINE) {
        line[length++] = byte & UART_DAMAGED ? '?' : byte;
    } else {
        too_long = true;
    }
    return true;
}

void text_tick(uint32_t now) {
    if (ended && now - last_byte >= SESSION_MS) {
        ended = false;
        length = 0;
        too_long = false;
    }
    if (counted && now - last_count >= WATCHDOG_MS && (output_enabled() & 1)) output_hold_zero_count();
}
