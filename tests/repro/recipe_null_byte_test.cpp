#include <treelet/pipeline/recipe_text.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace treelet {
namespace {

// The parser took a null byte for the end of the text and ignored what came after it.
TEST(Repro, RecipeWithANullByte) {
  const std::string text("lbvh\0 > nonsense", 16);
  EXPECT_THROW(parse_recipe_text(text), std::invalid_argument);
}

}  // namespace
}  // namespace treelet
