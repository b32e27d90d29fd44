#include <treelet/treelet.h>

int main() { return 0; }
