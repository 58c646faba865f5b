/* Links captures of an installed copy. */
#include <lum/capture/capture.h>
#include <lum/capture/demux.h>

#include <stdio.h>

int main(void)
{
    lum_capture *capture = NULL;
    lum_demux_options options = {.struct_size = sizeof options};
    lum_demux *demux = NULL;
    lum_error error;

    lum_layout_default(&options.layout);
    if (lum_demux_new(&options, &demux, &error) != 0) {
        return 1;
    }
    lum_demux_free(demux);
    (void)puts("capture");
    return lum_capture_open("no-such-file", &capture, &error) == 0;
}
