/* What the programs have in common: a binary STL file as a mesh, and the line that all of them print. */
#ifndef SAMPLE_H
#define SAMPLE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lamella/lamella.h>

/* The file's bytes, which `mesh` looks at; to be freed. NULL where there is no mesh. */
static unsigned char* read_sample(const char* path, lamella_mesh* mesh) {
    FILE* file = fopen(path, "rb");
    unsigned char* bytes = NULL;
    uint32_t triangles = 0;
    size_t size = 0;
    if (file == NULL) {
        return NULL;
    }
    fseek(file, 0, SEEK_END);
    size = (size_t)ftell(file);
    rewind(file);
    bytes = (unsigned char*)malloc(size);
    if (size < 84 || fread(bytes, 1, size, file) != size) {
        fprintf(stderr, "%s is no mesh\n", path);
        free(bytes);
        bytes = NULL;
    } else {
        memcpy(&triangles, bytes + 80, sizeof triangles);
        lamella_mesh_init(mesh);
        mesh->vertices = bytes + 84 + 12;
        mesh->vertex_stride = 50;
        mesh->triangle_count = triangles;
    }
    fclose(file);
    return bytes;
}

static void print_counts(const lamella_result* result) {
    lamella_view view;
    lamella_view_init(&view);
    lamella_result_view(result, &view);
    printf("%d layers, %d contours\n", (int)view.layer_count, (int)view.contour_count);
}

#endif
