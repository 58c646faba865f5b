#include "http.h"

#include <libwebsockets.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define HEAD_BYTES  2048u
#define PIECE_BYTES 16384u
#define VALUE_BYTES 512u
#define HEADERS_MAX 3u /* of an answer, in addition to those of all answers */

/* The WebSocket, as the page asks for it. */
#define SOCKET_PATH "/ws"

/* An answer that is not read for this long is given up. */
#define PATIENCE_S 20

void http_policy(const struct guard *guard, char out[HTTP_POLICY_BYTES])
{
    const unsigned port = guard->port;
    struct guard bare = *guard;
    char url[GUARD_TEXT_BYTES];
    bare.token[0] = '\0';
    guard_url(&bare, url);
    url[strlen(url) - 1u] = '\0'; /* the slash */
    (void)snprintf(out, HTTP_POLICY_BYTES,
                   "default-src 'none'; script-src 'self'; "
                   "style-src 'self'; img-src 'self' data: blob:; "
                   "connect-src 'self' ws://%s ws://localhost:%u; "
                   "base-uri 'none'; form-action 'none'; "
                   "frame-ancestors 'none'",
                   url + strlen("http://"), port);
}

struct reason {
    unsigned status;
    const char *text;
};

static const struct reason not_here = {HTTP_STATUS_NOT_FOUND,
                                       "There is nothing here.\n"};
static const struct reason not_so = {
    HTTP_STATUS_METHOD_NOT_ALLOWED, "This server accepts only GET and HEAD.\n"};
static const struct reason no_body = {HTTP_STATUS_REQ_ENTITY_TOO_LARGE,
                                      "Requests must not have a body.\n"};
static const struct reason only_gzip = {
    HTTP_STATUS_NOT_ACCEPTABLE,
    "This is stored compressed: send Accept-Encoding: gzip.\n"};
static const struct reason foreign_host = {
    HTTP_STATUS_FORBIDDEN,
    "This server answers only at the address that lumview printed.\n"};
static const struct reason foreign_origin = {
    HTTP_STATUS_FORBIDDEN, "This server answers only its own page.\n"};
static const struct reason no_token = {
    HTTP_STATUS_FORBIDDEN,
    "The token is missing or wrong: open the whole URL that lumview "
    "printed.\n"};

/* A header's value; false: there is none, or it is too long to be right. */
static bool read_header(struct lws *wsi, enum lws_token_indexes header,
                        char out[VALUE_BYTES])
{
    return lws_hdr_copy(wsi, out, (int)VALUE_BYTES, header) > 0;
}

static bool knows_token(struct lws *wsi, const struct guard *guard)
{
    char query[VALUE_BYTES];
    char cookies[VALUE_BYTES * 8u];
    const char *value =
        lws_get_urlarg_by_name(wsi, "token=", query, (int)sizeof query);
    const bool has_cookies = lws_hdr_copy(wsi, cookies, (int)sizeof cookies,
                                          WSI_TOKEN_HTTP_COOKIE) > 0;
    return guard_knows_token(guard, value, has_cookies ? cookies : NULL);
}

/* Why the sender of the request is refused; NULL: it is not. */
static const struct reason *check(struct lws *wsi, const struct guard *guard,
                                  bool needs_origin)
{
    char value[VALUE_BYTES];
    const bool has_origin = lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) > 0;
    if (!read_header(wsi, WSI_TOKEN_HOST, value) ||
        !guard_knows_host(guard, value)) {
        return &foreign_host;
    }
    if ((needs_origin || has_origin) &&
        (!read_header(wsi, WSI_TOKEN_ORIGIN, value) ||
         !guard_knows_origin(guard, value))) {
        return &foreign_origin;
    }
    return knows_token(wsi, guard) ? NULL : &no_token;
}

struct header {
    const char *name; /* with its colon; NULL: there is none */
    const char *value;
};

static int add_headers(struct lws *wsi, const struct header *headers,
                       unsigned char **p, unsigned char *end)
{
    int failed = 0;
    for (size_t i = 0; i < HEADERS_MAX && failed == 0; i++) {
        const char *value = headers[i].value;
        if (headers[i].name != NULL) {
            failed = lws_add_http_header_by_name(
                wsi, (const unsigned char *)headers[i].name,
                (const unsigned char *)value, (int)strlen(value), p, end);
        }
    }
    return failed;
}

/* The head of an answer; the headers that all have are libwebsockets' part.
 * Returns as lws_write. */
static int write_head(struct lws *wsi, unsigned status, const char *type,
                      size_t len, const struct header headers[HEADERS_MAX])
{
    unsigned char head[LWS_PRE + HEAD_BYTES];
    unsigned char *p = head + LWS_PRE;
    unsigned char *const end = head + sizeof head;
    if (lws_add_http_common_headers(wsi, status | LWSAHH_FLAG_NO_SERVER_NAME,
                                    type, len, &p, end) != 0 ||
        add_headers(wsi, headers, &p, end) != 0 ||
        lws_finalize_http_header(wsi, &p, end) != 0) {
        return -1;
    }
    return lws_write(wsi, head + LWS_PRE, (size_t)(p - head) - LWS_PRE,
                     LWS_WRITE_HTTP_HEADERS);
}

/* -1: it cannot be sent. */
static int refuse(struct lws *wsi, const struct reason *reason)
{
    unsigned char body[LWS_PRE + 128u];
    const size_t len = strlen(reason->text);
    const struct header headers[HEADERS_MAX] = {
        {"cache-control:", "no-store"},
        {reason == &not_so ? "allow:" : NULL, "GET, HEAD"},
    };
    (void)memcpy(body + LWS_PRE, reason->text, len);
    if (write_head(wsi, reason->status, "text/plain; charset=utf-8", len,
                   headers) < 0) {
        return -1;
    }
    return lws_write(wsi, body + LWS_PRE, len, LWS_WRITE_HTTP_FINAL) < 0 ? -1
                                                                         : 0;
}

static int complete(struct lws *wsi)
{
    return lws_http_transaction_completed(wsi) != 0 ? -1 : 0;
}

static const struct asset *find(const struct served *served, const char *path)
{
    const char *wanted = strcmp(path, "/") == 0 ? "/index.html" : path;
    for (size_t i = 0; i < assets_count; i++) {
        if (strcmp(assets[i].path, wanted) == 0) {
            return &assets[i];
        }
    }
    return served_find(served, path);
}

static int begin_asset(struct lws *wsi, const struct guard *guard, bool is_head,
                       struct http_answer *answer)
{
    char cookie[GUARD_TEXT_BYTES];
    const struct asset *asset = answer->asset;
    const bool sets_cookie = guard->token[0] != '\0' && !asset->is_kept;
    const struct header headers[HEADERS_MAX] = {
        {"cache-control:",
         asset->is_kept ? "private, max-age=31536000, immutable" : "no-store"},
        {asset->is_kept ? "content-encoding:" : NULL, "gzip"},
        {sets_cookie ? "set-cookie:" : NULL, cookie},
    };
    guard_cookie(guard, cookie);
    if (write_head(wsi, HTTP_STATUS_OK, asset->type, asset->len, headers) < 0) {
        return -1;
    }
    if (is_head || asset->len == 0) {
        return complete(wsi);
    }
    (void)lws_callback_on_writable(wsi);
    return 0;
}

static bool has_body(struct lws *wsi)
{
    char length[VALUE_BYTES];
    return lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_TRANSFER_ENCODING) > 0 ||
           (lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_CONTENT_LENGTH) > 0 &&
            (!read_header(wsi, WSI_TOKEN_HTTP_CONTENT_LENGTH, length) ||
             strcmp(length, "0") != 0));
}

/* Who says nothing of it takes any (RFC 9110, 12.5.3). */
static bool takes_gzip(struct lws *wsi)
{
    char codings[VALUE_BYTES];
    if (lws_hdr_total_length(wsi, WSI_TOKEN_HTTP_ACCEPT_ENCODING) <= 0) {
        return true;
    }
    return read_header(wsi, WSI_TOKEN_HTTP_ACCEPT_ENCODING, codings) &&
           (strchr(codings, '*') != NULL || strstr(codings, "gzip") != NULL);
}

/* A request of another kind may have a body: no more is read. */
static int refuse_and_close(struct lws *wsi, const struct reason *reason)
{
    (void)refuse(wsi, reason);
    return -1;
}

int http_begin(struct lws *wsi, const struct guard *guard,
               const struct served *served, const char *path,
               struct http_answer *answer)
{
    const struct reason *wrong = check(wsi, guard, false);
    const bool is_get = lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) > 0;
    const bool is_head = lws_hdr_total_length(wsi, WSI_TOKEN_HEAD_URI) > 0;
    if (wrong != NULL) {
        return refuse_and_close(wsi, wrong);
    }
    if (!is_get && !is_head) {
        return refuse_and_close(wsi, &not_so);
    }
    if (has_body(wsi)) {
        return refuse_and_close(wsi, &no_body);
    }
    *answer = (struct http_answer){find(served, path), 0};
    if (answer->asset == NULL) {
        return refuse_and_close(wsi, &not_here);
    }
    if (answer->asset->is_kept && !takes_gzip(wsi)) {
        answer->asset = NULL;
        return refuse_and_close(wsi, &only_gzip);
    }
    return begin_asset(wsi, guard, is_head, answer);
}

int http_go_on(struct lws *wsi, struct http_answer *answer)
{
    unsigned char piece[LWS_PRE + PIECE_BYTES];
    if (answer->asset == NULL) {
        return 0;
    }
    const size_t left = answer->asset->len - answer->sent;
    const bool is_last = left <= PIECE_BYTES;
    const size_t n = is_last ? left : PIECE_BYTES;
    (void)memcpy(piece + LWS_PRE, answer->asset->bytes + answer->sent, n);
    lws_set_timeout(wsi, PENDING_TIMEOUT_HTTP_CONTENT, PATIENCE_S);
    if (lws_write(wsi, piece + LWS_PRE, n,
                  is_last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) {
        return -1;
    }
    answer->sent += n;
    if (is_last) {
        answer->asset = NULL;
        return complete(wsi);
    }
    (void)lws_callback_on_writable(wsi);
    return 0;
}

static bool is_header(struct lws *wsi, enum lws_token_indexes header,
                      const char *expected)
{
    char value[VALUE_BYTES];
    return read_header(wsi, header, value) && strcmp(value, expected) == 0;
}

int http_check_upgrade(struct lws *wsi, const struct guard *guard,
                       const char *kind)
{
    const struct reason *wrong = check(wsi, guard, true);
    if (wrong == NULL &&
        (kind == NULL || strcmp(kind, "websocket") != 0 ||
         !is_header(wsi, WSI_TOKEN_GET_URI, SOCKET_PATH) ||
         !is_header(wsi, WSI_TOKEN_PROTOCOL, SOCKET_PROTOCOL) ||
         !is_header(wsi, WSI_TOKEN_VERSION, "13"))) {
        wrong = &not_here;
    }
    if (wrong == NULL) {
        return 0;
    }
    return refuse(wsi, wrong) < 0 ? -1 : 1;
}
