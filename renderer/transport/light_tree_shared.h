// How a light is chosen by the tree, for both compilers.
#ifndef PHOTOND_LIGHT_TREE_SHARED_H
#define PHOTOND_LIGHT_TREE_SHARED_H

// Of two clusters that can both reach a point, each is chosen with this probability at least. What they could bring
// knows nothing of what lies in between: a lamp in a room must not starve because one outside of it is far brighter,
// and a share below 2^-24 is never drawn. At most it takes this part of the samples at each level of the tree.
#define LIGHT_TREE_LEAST_SHARE 0.0078125f

#endif
