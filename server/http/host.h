// By what name a server is called, and by whose page: the headers Host and Origin. Pure functions.
#pragma once

#include <httplib.h>

#include <string>
#include <string_view>

namespace qray::server {

// This machine, by which a page of another site cannot be called: localhost, or an address of the
// loopback network, with or without the brackets of IPv6.
bool is_loopback(std::string_view host);

// Of "Name:80", "name"; of "[::1]:80", "[::1]".
std::string host_name(const httplib::Request& req);

// A page of another site may make a browser send requests here; browsers name that site.
bool has_foreign_origin(const httplib::Request& req);

}  // namespace qray::server
