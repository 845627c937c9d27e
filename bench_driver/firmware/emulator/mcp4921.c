#include "mcp4921.h"

#define NOT_FOR_THIS_CHANNEL 0x8000
#define GAIN_1 0x2000
#define ACTIVE 0x1000

void mcp4921_power_on(struct mcp4921 *chip) { *chip = (struct mcp4921){.code = MCP4921_OFF}; }

void mcp4921_select(struct mcp4921 *chip, bool selected) {
    bool whole = chip->selected && !selected && chip->bytes == 2;
    if (whole && !(chip->shifted & NOT_FOR_THIS_CHANNEL)) {
        int code = (int)(chip->shifted & 0x0FFF);
        if (!(chip->shifted & GAIN_1)) code = code > 2047 ? 4095 : 2 * code; // gain 2 saturates at the reference
        chip->code = chip->shifted & ACTIVE ? code : MCP4921_OFF;
    }
    if (selected != chip->selected) chip->bytes = chip->shifted = 0;
    chip->selected = selected;
}

void mcp4921_byte(struct mcp4921 *chip, uint8_t byte) {
    if (!chip->selected) return;
    chip->shifted = (chip->shifted << 8 | byte) & 0xFFFF;
    chip->bytes++;
}
