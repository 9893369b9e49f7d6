#include "server/webhooks/addresses.h"

#include <netdb.h>

#include <algorithm>
#include <cstring>
#include <future>
#include <thread>

namespace qray::server {
namespace {

struct V4Block {
  uint32_t address;
  int bits;
};
// RFC 6890 and those that it names: whatever is not for the whole internet.
constexpr V4Block kV4Closed[] = {
    {0x00000000, 8},  {0x0A000000, 8},  {0x64400000, 10}, {0x7F000000, 8},  {0xA9FE0000, 16},
    {0xAC100000, 12}, {0xC0000000, 24}, {0xC0000200, 24}, {0xC0586300, 24}, {0xC0A80000, 16},
    {0xC6120000, 15}, {0xC6336400, 24}, {0xCB007100, 24}, {0xE0000000, 4},  {0xF0000000, 4}};

bool is_public_v4(uint32_t address) {
  return std::none_of(std::begin(kV4Closed), std::end(kV4Closed), [&](const V4Block& block) {
    return (address ^ block.address) >> (32 - block.bits) == 0;
  });
}

bool is_public_v6(const in6_addr& address) {
  const auto* b = address.s6_addr;
  const auto word = [&](int at) { return b[at] << 8 | b[at + 1]; };
  if (IN6_IS_ADDR_V4MAPPED(&address))
    return is_public_v4(static_cast<uint32_t>(word(12)) << 16 | static_cast<uint32_t>(word(14)));
  if (b[0] >> 5 != 1) return false;                         // 2000::/3 alone is given out
  if (word(0) == 0x2001 && word(2) < 0x0200) return false;  // 2001::/23: Teredo and the like
  if (word(0) == 0x2001 && word(2) == 0x0DB8) return false;
  if (word(0) == 0x2002) return false;  // 6to4: an IPv4 address inside
  return word(0) != 0x3FFF || word(2) >> 12 != 0;
}

struct Found {
  int error = 0;
  std::vector<Address> addresses;
};

Found ask(const std::string& host, uint16_t port) {
  addrinfo hints{}, *list = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  Found found;
  found.error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
  if (found.error != 0) return found;
  for (const addrinfo* one = list; one; one = one->ai_next) {
    if (one->ai_family != AF_INET && one->ai_family != AF_INET6) continue;
    Address address{};
    std::memcpy(&address, one->ai_addr, std::min<size_t>(one->ai_addrlen, sizeof address));
    found.addresses.push_back(address);
  }
  ::freeaddrinfo(list);
  return found;
}

}  // namespace

bool is_public(const Address& address) {
  if (address.any.sa_family == AF_INET) return is_public_v4(ntohl(address.v4.sin_addr.s_addr));
  return address.any.sa_family == AF_INET6 && is_public_v6(address.v6.sin6_addr);
}

Result<std::vector<Address>> resolve(const std::string& host, uint16_t port,
                                     std::chrono::steady_clock::time_point deadline,
                                     const std::stop_token& stop) {
  // Nothing can end a question to the system, so that its thread is left to itself.
  auto promise = std::make_shared<std::promise<Found>>();
  std::future<Found> answer = promise->get_future();
  std::thread([promise, host, port] { promise->set_value(ask(host, port)); }).detach();
  constexpr std::chrono::milliseconds kLook{20};
  while (answer.wait_for(kLook) != std::future_status::ready)
    if (stop.stop_requested() || std::chrono::steady_clock::now() > deadline)
      return Error{ErrorCode::kIo, "its name was not found in time", host};
  Found found = answer.get();
  if (found.error != 0 || found.addresses.empty())
    return Error{ErrorCode::kIo,
                 found.error != 0 ? ::gai_strerror(found.error) : "the name has no address", host};
  return std::move(found.addresses);
}

}  // namespace qray::server
