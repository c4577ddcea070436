/* The command line's reader of CSV files, with any bytes. It ends the program with a
 * message, or returns tables that can be used. Here the end of the program returns to the
 * harness. */
#define _XOPEN_SOURCE 700

#include <math.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

static jmp_buf ended;
static FILE *opened, *nowhere;
static const uint8_t *content;
static size_t content_size;

__attribute__((noreturn)) static void fuzz_exit(int status)
{
    longjmp(ended, status + 1);
}

/* The only path that is not read from the bytes: the cameras that observations refer to. */
static char CAMERAS[] = "camera,width,height,fx,fy,cx,cy\ncam,640,480,500,500,320,240\n";

static FILE *fuzz_open(const char *path)
{
    if (opened != NULL) {
        fclose(opened);
    }
    opened = strcmp(path, "cameras") == 0
                 ? fmemopen(CAMERAS, sizeof CAMERAS - 1, "rb")
                 : fmemopen((void *)(uintptr_t)content, content_size, "rb");
    return opened;
}

static int fuzz_close(FILE *file)
{
    opened = NULL;
    return (fclose)(file);
}

#define exit fuzz_exit
#define atexit(function) (void)(function)
#define cli_os_open fuzz_open
#define fclose fuzz_close
#undef stderr
#define stderr nowhere
#include "../../examples/cli_csv.c"
#undef fclose

/* Replaces the end of the program. */
static void end(void)
{
    free_blocks();
    blocks = NULL;
    n_blocks = room_for_blocks = 0;
    free(held);
    held = NULL;
    held_size = held_room = 0;
    is_holding = 0;
    if (opened != NULL) {
        fclose(opened);
        opened = NULL;
    }
}

/* ---- tables that were accepted --------------------------------------------- */

static void check_cameras(const cli_cameras *cameras)
{
    size_t i;

    PROMISE(cameras->names.count == cameras->table.n_rows && cameras->names.count >= 1);
    for (i = 0; i < cameras->names.count; i++) {
        PROMISE(rigcal_camera_check(&cameras->camera[i]) == RIGCAL_OK);
        PROMISE(cli_names_find(&cameras->names, cameras->names.name[i]) == i);
    }
}

static void check_observations(const cli_observations *observations)
{
    size_t i;

    PROMISE(observations->count >= 1);
    for (i = 0; i < observations->count; i++) {
        const cli_observation *o = &observations->list[i];

        PROMISE(o->camera == 0 && o->frame < observations->frames.count);
        PROMISE(o->place < observations->n_places);
        PROMISE(cli_point(observations, o) < observations->points.count);
        PROMISE(fuzz_all_finite(cli_X(observations, o), 3) && fuzz_all_finite(o->uv, 2));
        PROMISE(i == 0 || o[-1].frame <= o->frame);
    }
}

static void read_any(int kind)
{
    cli_cameras cameras;
    cli_observations observations;
    cli_transforms transforms;
    csv_table table;
    size_t row, column;

    switch (kind) {
    case 0:
        cli_cameras_read(&cameras, "any");
        check_cameras(&cameras);
        break;
    case 1:
        cli_cameras_read(&cameras, "cameras");
        cli_observations_read(&observations, "any", &cameras, 1);
        check_observations(&observations);
        break;
    case 2:
        cli_transforms_read(&transforms, "any", "camera", NULL);
        for (row = 0; row < transforms.names.count; row++) {
            PROMISE(fuzz_is_rotation(transforms.transform[row].R, FUZZ_TOL(4e-6, 4e-3)));
        }
        break;
    default:
        csv_read(&table, "any");
        PROMISE(table.n_columns >= 1 && table.n_rows >= 1);
        for (row = 0; row < table.n_rows; row++) {
            for (column = 0; column < table.n_columns; column++) {
                PROMISE(isfinite(csv_number(&table, row, column)));
            }
        }
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 2) {
        return 0;
    }
    if (nowhere == NULL) {
        nowhere = fopen("/dev/null", "w");
        PROMISE(nowhere != NULL);
    }
    content = data + 1;
    content_size = size - 1;
    if (setjmp(ended) == 0) {
        read_any(data[0] % 4);
    }
    end();
    return 0;
}
