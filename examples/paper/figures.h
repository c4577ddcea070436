/* figures.h - one function for each figure or two. It writes the tables of its name. */
#ifndef PAPER_FIGURES_H
#define PAPER_FIGURES_H

/* searches.c */
void figure_3(void);
void figure_4(void);
void figure_5(void);
void figure_6(void);
void figure_6_share(void);
void figure_8(void);
void figure_three(void);
void figure_9(void);
void figure_counts(void);
void figure_choices(void);
void figure_conditions(void);

/* accuracy.c */
void figures_10_to_14(void);
void figure_14_settling(void);
void figure_14_lines(void);

#endif
