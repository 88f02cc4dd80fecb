// Finds the types that C++ source defines for all to see: what the one-definition rule is about.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// The words and signs of C++ source, without comments, directives, numbers and quoted text.
inline std::vector<std::string> source_tokens(std::string_view text) {
  std::vector<std::string> tokens;
  const auto is_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
  };
  const auto past = [&](std::string_view end, std::size_t from) {
    const std::size_t at = text.find(end, from);
    return at == std::string_view::npos ? text.size() : at + end.size();
  };
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("//")) {
      i = past("\n", i);
    } else if (rest.starts_with("/*")) {
      i = past("*/", i + 2);
    } else if (rest.starts_with('#')) {  // a directive, with the lines that continue it
      while (i < text.size() && text[i] != '\n') i += text[i] == '\\' ? 2 : 1;
    } else if (rest.starts_with("R\"")) {
      const std::size_t open = text.find('(', i);
      i = past(")" + std::string(text.substr(i + 2, open - i - 2)) + "\"", i);
    } else if (rest[0] == '"' || rest[0] == '\'') {
      for (++i; i < text.size() && text[i] != rest[0]; ++i) i += text[i] == '\\';
      ++i;
    } else if (std::isdigit(static_cast<unsigned char>(rest[0]))) {
      while (i < text.size() && (is_word(text[i]) || text[i] == '\'' || text[i] == '.')) ++i;
    } else if (is_word(rest[0])) {
      const std::size_t begin = i;
      while (i < text.size() && is_word(text[i])) ++i;
      tokens.emplace_back(text.substr(begin, i - begin));
    } else if (rest.starts_with("::")) {
      tokens.emplace_back("::");
      i += 2;
    } else {
      if (!std::isspace(static_cast<unsigned char>(rest[0]))) tokens.emplace_back(1, rest[0]);
      ++i;
    }
  }
  return tokens;
}

/// The name that the tokens before a `{` or `;` define in a namespace, or empty.
inline std::string defined_type(std::vector<std::string> head) {
  const auto drop = [&](std::size_t count) {
    head.erase(head.begin(),
               head.begin() + static_cast<std::ptrdiff_t>(std::min(count, head.size())));
  };
  if (!head.empty() && head[0] == "template") {
    std::size_t end = 1;
    for (int depth = 0; end < head.size(); ++end) {
      depth += head[end] == "<" ? 1 : head[end] == ">" ? -1 : 0;
      if (depth == 0) break;
    }
    drop(end + 1);
  }
  if (head.size() > 2 && head[0] == "using" && head[2] == "=") return head[1];
  const auto is_key = [](const std::string& word) {
    return word == "struct" || word == "class" || word == "union" || word == "enum";
  };
  if (head.empty() || !is_key(head[0])) return {};
  while (!head.empty() && is_key(head[0])) drop(1);
  const auto end = std::ranges::find_if(
      head, [](const std::string& word) { return word == ":" || word == "final"; });
  std::string name;
  for (auto word = head.begin(); word != end; ++word) name += *word;
  return name;
}

/// The full names of the types, enumerations and aliases that `text` defines in named namespaces.
inline std::vector<std::string> type_definitions(std::string_view text) {
  struct Scope {
    std::string prefix;  // "taut::direct::"
    bool seen = true;    // from other files: neither unnamed nor within a type or function
  };
  std::vector<Scope> scopes{{}};
  std::vector<std::string> found, head;
  for (const std::string& token : source_tokens(text)) {
    if (token != "{" && token != "}" && token != ";") {
      head.push_back(token);
      continue;
    }
    const auto name = std::ranges::find(head, "namespace");
    const bool is_namespace = name != head.end();
    const std::string type = is_namespace || token == "}" ? "" : defined_type(head);
    const bool is_alias = !head.empty() && std::ranges::find(head, "using") != head.end();
    if (scopes.back().seen && !type.empty() && (token == "{") != is_alias) {
      found.push_back(scopes.back().prefix + type);
    }
    if (token == "{") {
      Scope inner = scopes.back();
      const bool is_linkage = head.size() == 1 && head[0] == "extern";
      inner.seen &= is_linkage || (is_namespace && name + 1 != head.end());
      if (is_namespace) {
        for (auto word = name + 1; word != head.end(); ++word) inner.prefix += *word;
        inner.prefix += "::";
      }
      scopes.push_back(inner);
    } else if (token == "}" && scopes.size() > 1) {
      scopes.pop_back();
    }
    head.clear();
  }
  return found;
}

}  // namespace taut
