// window.lumview: what the page shows, for tests and the curious. All of it
// is read only; nothing here changes the page or reaches the server.
//
// connected      whether there is a connection
// frame          number of the newest frame shown, null before the first
// began          { utc, kind, error }: when that frame began, seconds; kind is "fitted" or
//                "arrival"; null: not known
// smooth         window of its smoothing
// share          of its points that have come
// shown          pictures that frames became; one that comes slowly becomes several
// received       frames that came, whole or in part
// pictures       pictures drawn
// points         points in the frames shown, before any filter
// sides          those by the first profile, and by the second
// drawn          those of them in the last picture: fewer while the camera moves
// lit            whether the picture has eye-dome lighting
// moving         whether the camera moves
// counts()       { total, shown, blue, green, rising, falling, returns }: what
//                passes the filters, counted now
// camera()       { position, target, yaw, pitch, distance, flat }, degrees
// settings()     a copy of all settings
// status()       the server's last status, null before the first
// hello()        the server's greeting
// domain()       the values at both ends of the colours
// picked()       the picked point, or null
// distance()     { from, to, distance, horizontal, x, y, z } between two, or null
// selection()    { count, min, max, plane } of the selected points; plane: { normal,
//                distance, residual } or null; null: nothing is selected
// strip()        { rows, columns, frame, index }: the pictures beside the cloud, the
//                point of each pixel; null: they are not shown
// place(i)       { x, y, depth, visible, range } of point i of the newest frame on the page
// positions()    { step, xyz } of the newest frame: to which step its coordinates are
//                rounded at most, and the coordinates of all its points
// beside()       { labels, truth }: the names of labels, how many true points are shown
// memory()       { geometries, textures, programs } of the graphics card
export function exposeProbe(parts) {
    const getters = {};
    for (const [name, value] of Object.entries(parts)) {
        getters[name] = { enumerable: true, get: value };
    }
    Object.defineProperty(window, "lumview", { value: Object.freeze(Object.create(null, getters)) });
}
