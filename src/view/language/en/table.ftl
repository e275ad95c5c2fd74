# Headings of tables that sort their rows.

table-sort-hint = Sort by this column
table-ascending-hint = Sorted in ascending order; a click reverses it
table-descending-hint = Sorted in descending order; a click reverses it
