#include "line.h"

#include "port.h"

#define R(x) ((rigcal_real)(x))

void put_text(line *out, const char *text)
{
    while (*text != '\0' && out->n < sizeof out->text) {
        out->text[out->n++] = *text++;
    }
}

/* Appends x with at least `digits` digits. */
static void put_unsigned(line *out, uint32_t x, int digits)
{
    char reversed[10];
    int n = 0;
    for (; x > 0 || n < digits; x /= 10) {
        reversed[n++] = (char)('0' + x % 10);
    }
    while (n > 0 && out->n < sizeof out->text) {
        out->text[out->n++] = reversed[--n];
    }
}

/* Appends x with six decimals, by way of whole millionths. Beyond +-2147 it sends that
 * limit. */
void put_micro(line *out, rigcal_real x)
{
    const rigcal_real most = R(2147.0);
    const rigcal_real within = (x < -most) ? -most : (x > most) ? most : x;
    const int32_t micro = (int32_t)(within * R(1e6) + (within < 0 ? R(-0.5) : R(0.5)));
    const uint32_t size = (micro < 0) ? 0U - (uint32_t)micro : (uint32_t)micro;
    put_text(out, (micro < 0) ? "-" : "");
    put_unsigned(out, size / 1000000, 1);
    put_text(out, ".");
    put_unsigned(out, size % 1000000, 6);
}

void put_count(line *out, const char *name, uint32_t x)
{
    put_text(out, name);
    put_unsigned(out, x, 1);
}

void put_vector(line *out, const char *name, const rigcal_real x[3])
{
    put_text(out, name);
    put_micro(out, x[0]);
    put_text(out, ",");
    put_micro(out, x[1]);
    put_text(out, ",");
    put_micro(out, x[2]);
}

void put_status(line *out, rigcal_status status)
{
    put_text(out, " status=");
    put_text(out, rigcal_status_name(status) + sizeof "RIGCAL_" - 1);
}

void send_line(line *out)
{
    put_text(out, "\r\n");
    port_send(out->text, out->n);
}
