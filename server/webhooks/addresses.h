// Where a name leads, and whether webhooks may go there. Any thread.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace qray::server {

union Address {
  sockaddr any;
  sockaddr_in v4;
  sockaddr_in6 v6;
  socklen_t size() const { return any.sa_family == AF_INET ? sizeof v4 : sizeof v6; }
};

// Of the internet. Not: this machine, networks of one's own, of a link, for documents and tests,
// and IPv6 addresses that stand for such an IPv4 one.
bool is_public(const Address& address);

// Asks the system, which may take its time: gives up at `deadline` or when stopped. At least one.
// kInvalid, kIo.
Result<std::vector<Address>> resolve(const std::string& host, uint16_t port,
                                     std::chrono::steady_clock::time_point deadline,
                                     const std::stop_token& stop);

}  // namespace qray::server
