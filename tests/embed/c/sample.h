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
        LAMELLA_INIT(mesh, LAMELLA_MESH);
        mesh->vertices = bytes + 84 + 12;
        mesh->vertex_stride = 50;
        mesh->triangle_count = triangles;
    }
    fclose(file);
    return bytes;
}

static void print_counts(const lamella_result* result) {
    lamella_view view;
    LAMELLA_INIT(&view, LAMELLA_VIEW);
    lamella_result_view(result, &view);
    printf("%d layers, %d contours\n", (int)view.info.layers, (int)view.info.contours);
}

#endif
