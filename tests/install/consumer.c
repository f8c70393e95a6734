/* A C program of somebody else's: builds a tree through the installed C interface. */
#include <occlude/c/occlude.h>

#include <stdio.h>

int main(void)
{
    const occlude_item item = {{0, 0, 0}, {1, 1, 1}, 12, 0};
    occlude_hierarchy* hierarchy = NULL;
    if (occlude_hierarchy_create("bvh", &item, 1, 0, NULL, 0, &hierarchy) != OCCLUDE_OK) {
        fprintf(stderr, "%s\n", occlude_last_error());
        return 1;
    }
    const size_t count = occlude_hierarchy_item_count(hierarchy);
    occlude_hierarchy_destroy(hierarchy);
    printf("occlude %s, %zu item\n", occlude_version(), count);
    return count == 1 ? 0 : 1;
}
