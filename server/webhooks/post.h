// One POST to an address that was judged before: the name is not asked for again. Any thread.
#pragma once

#include <string_view>

#include "server/webhooks/addresses.h"
#include "server/webhooks/url.h"

namespace qray::server {

// Sends `request`, head and body, and reads the status of the answer, nothing more of it. By TLS
// the certificate must be the host's. All of it ends at `deadline`. kIo.
Result<int> post(const WebhookUrl& url, const Address& address, std::string_view request,
                 std::chrono::steady_clock::time_point deadline, const std::stop_token& stop);

}  // namespace qray::server
