#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>

/// The pages for a browser: one template, which shows what data stand in it.
namespace slicemorph {

/// A script element of the page with data that its program reads by `id`. `text`: of base64Of, or without `</`.
std::string pageData(const std::string& id, const std::string& type, const std::string& text);
/// The same of JSON, in which what could end the element is escaped.
std::string pageData(const std::string& id, const nlohmann::ordered_json& json);

std::string base64Of(std::string_view bytes);

/// The page: one HTML file that needs no network. `data`: script elements.
std::string pageWith(const std::string& data);

}  // namespace slicemorph
