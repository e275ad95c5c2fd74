# Spaltenköpfe von Tabellen, die ihre Zeilen sortieren.

table-sort-hint = Nach dieser Spalte sortieren
table-ascending-hint = Aufsteigend sortiert; ein Klick kehrt die Reihenfolge um
table-descending-hint = Absteigend sortiert; ein Klick kehrt die Reihenfolge um
