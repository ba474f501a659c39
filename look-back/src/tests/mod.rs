mod drive;
mod drives;
mod groups;
mod random;
mod sizes;
mod steps;
